"""The study of own cars, in small: what their brochure says, what is true of them, and how they are judged."""

import dataclasses

import numpy as np
import pytest

from shared_data import shared_data
from tierod.io.readers import read
from tierod.vehicles import load
from tierod_lab.ground.cars.catalogue import load as car_of
from tierod_lab.papers.own_car.brochure import brochure_car, identified
from tierod_lab.papers.own_car.cars import BASES, drawn, true_values
from tierod_lab.papers.own_car.judging import KNOWN, Case, beside_reference, over_cars, over_real_cars, without_truth
from tierod_lab.studies.metrics import Frame


def test_every_class_is_drawn_and_differs_from_its_brochure_within_reason():
    cars = [drawn(number, 1) for number in range(len(BASES))]
    assert {each.name.split()[1] for each in cars} == {"quadricycle", "small", "midsize", "large", "suv", "van"}
    assert {each.block.powertrain.front_share for each in cars} == {0.0, 1.0}
    for car in cars:
        apart = [
            (car.true[name] - car.brochure[name]) / car.brochure.parameters[name].standard_deviation
            for name in ("mass", "front_distance", "steering_ratio", "front_cornering_stiffness", "column_damping")
        ]
        assert 0.0 < max(map(abs, apart)) < 4.0
        assert car.true.parameters["mass"].standard_deviation == 0.0
        assert car.block.driver.mass == car.block.chassis.mass == car.true["mass"]
    assert drawn(0, 1).true["mass"] == cars[0].true["mass"] != drawn(0, 6).true["mass"]


def test_true_values_are_those_of_the_file_of_the_shipped_car():
    values, file = true_values(car_of("midsize-eps").block), load("midsize-eps")
    for name in ("mass", "yaw_inertia", "front_distance", "front_cornering_stiffness", "steering_ratio"):
        assert values[name] == pytest.approx(file[name], rel=1e-3)
    for name in ("column_inertia", "column_damping", "torsion_bar_stiffness", "nominal_friction"):
        assert values[name] == pytest.approx(file[name], rel=0.03)


def test_a_brochure_of_counts_holds_no_torque_and_a_doubtful_identification_changes_nothing():
    car = brochure_car("car", "suv", 1700.0, 2.7, torques_known=False)
    assert not car.calibrated
    assert "nominal_friction" not in car
    assert car["front_distance"] + car["rear_distance"] == pytest.approx(2.7)
    assert identified(car, dataclasses.make_dataclass("Found", ["doubt"])("nothing was learnt")) is car


@pytest.mark.slow
def test_a_car_by_its_brochure_is_held_by_its_bands_and_accused_of_nothing():
    found = Frame.of("cars", over_cars(Case(number=0, seed=2, learning=0.0, minutes=1.4, drives=1)))
    assert set(found["file"]) == {"brochure", "true"}
    for monitor in ("sideslip", "driver-torque"):
        own = found.where({"monitor": monitor, "file": "brochure"})
        assert own["samples"][0] > 100
        assert own["share"][0] > 0.9
        assert own["error"][0] > 0.0
    assert found["false"].sum() == 0.0


def test_typical_values_hold_the_optical_reference_of_a_real_car_which_no_monitor_sees(monkeypatch, tmp_path):
    path = shared_data("revsted_slip_angle", "obd.csv")
    recording = read(path, channel_map=load("revsted-car").channel_map)
    assert "sideslip_angle" not in without_truth(recording)
    known = next(each for each in KNOWN if each.vehicle == "revsted-car")
    brochure = brochure_car(known.vehicle, known.kind, known.mass, known.wheelbase)
    held, error = beside_reference(recording, brochure, known.reference)
    assert held > 0.9
    assert np.degrees(error) < 1.0
    monkeypatch.setenv("TIEROD_DATA", str(tmp_path))
    assert over_real_cars(known) == []
