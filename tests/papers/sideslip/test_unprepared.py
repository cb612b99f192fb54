"""Cars without preparation: typical values, and what the estimator makes of them."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.claims import Claim
from tierod.core.recording import Channel, Recording
from tierod.monitors.sideslip.tuning import YAW_ADAPTATION, tuning_of
from tierod.vehicles import load
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.papers.sideslip import race_blocks, slow_cars, unprepared
from tierod_lab.papers.sideslip.calibration import BesideTruth
from tierod_lab.papers.sideslip.typical_cars import PASSENGER, SPORTS, kinematic, measured_wrong, steady, typical
from tierod_lab.studies.effort import Effort


def claims(items):
    return {item.id: item for item in items if isinstance(item, Claim)}


def test_a_typical_car_keeps_tape_and_scale_and_nothing_that_was_fitted():
    car = load("ferrari-250lm")
    found = typical(car, SPORTS, rear_distance=1.1)
    assert found["mass"] == car["mass"]
    assert found["rear_distance"] == 1.1
    assert found["front_cornering_stiffness"] == pytest.approx(15.0 * 982.0 * 9.81 * 1.1 / 2.43, rel=1e-3)
    assert not [name for name in found.parameters if name.endswith(("_noise", "_drift", "_wander", "_wander_time"))]
    assert tuning_of(found).yaw_adaptation == YAW_ADAPTATION
    first, *corners = measured_wrong(car, SPORTS)
    assert first["rear_distance"] == car["rear_distance"]
    assert {round(each["rear_distance"] - car["rear_distance"], 6) for each in corners} == {-0.03, 0.03}
    assert len(corners) == 8


def test_simple_estimates_are_geometry_and_the_slip_of_the_rear_axle():
    time = np.arange(200) / 50.0
    values = {"vehicle_speed": 5.0, "yaw_rate": 0.4, "sideslip_angle": 0.0}
    made = Recording({name: Channel(name, time, np.full(200, value), "") for name, value in values.items()})
    car = typical(load("revsted-car"), PASSENGER)
    rolling = math.atan(car["rear_distance"] * 0.4 / 5.0)
    np.testing.assert_allclose(kinematic(made, car, 50.0).estimate, rolling)
    slip = 2.0 / 9.81 / PASSENGER.rear_stiffness
    np.testing.assert_allclose(np.tan(steady(made, car, 50.0).estimate), math.tan(rolling) - slip, rtol=1e-3)


def test_without_recordings_they_say_so(monkeypatch, tmp_path):
    monkeypatch.setenv("TIEROD_DATA", str(tmp_path))
    found = claims([*unprepared.items(Effort()), *race_blocks.items(Effort())])
    assert len(found) == 10
    assert {each.note for each in found.values()} == {NO_DATA}


def test_an_unprepared_passenger_car_is_estimated_better_than_by_simple_means(monkeypatch):
    monkeypatch.setenv("TIEROD_DATA", str(shared_data("revsted_slip_angle").parent))
    found = claims(unprepared.items(Effort()))
    assert found["unprepared.passenger-car-worse"].met
    assert found["unprepared.passenger-car-simple"].met
    assert found["unprepared.passenger-car-band"].measured > 0.85


def test_a_slow_car_without_accelerometer_never_starts_anew_and_beats_geometry():
    small = slow_cars.cars()["small car, 1050 kg"]
    found = slow_cars.judged(small, 5, (3.0, 8.0))
    assert found.restarts == 0.0
    assert found.mean < 0.3
    assert found.rms < 0.4
    assert found.beside_kinematics < 1.0
    assert found.coverage > 0.9


def test_a_block_is_judged_by_itself():
    time = np.arange(1001) / 10.0
    truth = Channel("sideslip_angle", time, np.zeros(1001), "rad")
    laps = Recording({"sideslip_angle": truth, "vehicle_speed": Channel("vehicle_speed", time, time, "m/s")})
    error = np.where(time < 40.0, 1.0, 0.01)
    seen = BesideTruth(time, error, np.full(1001, 0.006), truth.values)
    third = race_blocks.block(laps, seen, 3)
    assert third.figures.mean_absolute == pytest.approx(0.01)
    assert third.speed.min() == pytest.approx(40.0)
    assert third.inside.all()
    assert not race_blocks.block(laps, seen, 2).inside.any()


@pytest.mark.slow
def test_the_claims_on_small_cars_hold():
    assert all(each.met for each in claims(slow_cars.items(Effort())).values())


@pytest.mark.slow
def test_blocks_of_the_race_laps_with_files_of_those_before(monkeypatch):
    monkeypatch.setenv("TIEROD_DATA", str(shared_data("ferrari_250lm_race").parent))
    found = claims(race_blocks.items(Effort(processes=1)))
    assert all(found[f"blocks.{key}"].met for key in ("mean", "rms", "stratum"))
    assert found["blocks.band"].measured > 0.92


def test_a_yaw_rate_that_sticks_does_not_carry_an_adapted_filter_away():
    """Raised noises keep the innovations small, so that the sideslip angle itself shows that the filter is lost."""
    small = slow_cars.cars()["small car, 1050 kg"]
    drive, car = slow_cars.driven(small.chassis, 8.0, 5), slow_cars.brochure(small)
    rate = drive["yaw_rate"]
    stuck = np.where((rate.time > 20.0) & (rate.time < 25.0), 1.5, rate.values)
    seen = slow_cars.estimated(drive.with_channels([dataclasses.replace(rate, values=stuck)]), car)
    while_stuck = (seen.time > 20.0) & (seen.time < 25.5)
    assert seen.result["estimate.restarted"][while_stuck].sum() >= 1.0
    assert not seen.result["estimate.restarted"][~while_stuck].any()
    assert seen.figures(45.0).rms < math.radians(0.4)
