"""Virtual cars that are not known: what their brochure says, and what is true of them."""

from __future__ import annotations

import dataclasses

import pytest

from tierod.vehicles import load
from tierod_lab.ground.cars.catalogue import load as car_of
from tierod_lab.papers.own_car.brochure import brochure_car, identified
from tierod_lab.papers.own_car.cars import BASES, drawn, true_values


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


def test_the_same_number_and_seed_give_the_same_car_and_others_another():
    assert drawn(0, 5).true["mass"] == drawn(0, 5).true["mass"] != drawn(0, 6).true["mass"]


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
