"""Datasets of the study in a small size, against what must come out."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.monitors.sideslip.tuning import YAW_ADAPTATION, tuning_of
from tierod.vehicles import load
from tierod_lab.papers.sideslip import combined_datasets, observer_datasets, real_datasets, typical_cars
from tierod_lab.papers.sideslip.calibration import beside_truth
from tierod_lab.papers.sideslip.combined_drives import FRONT, REAR, both_stiff, from_file, general
from tierod_lab.papers.sideslip.typical_cars import PASSENGER, SPORTS, kinematic, measured_wrong, steady, typical

TIME = np.arange(2000) / 100.0


@pytest.mark.parametrize("speed", [6.7, 25.0])
def test_in_neutral_steer_the_yaw_rate_does_not_hang_on_the_sideslip(speed):
    found = observer_datasets.neutral_steer((1.0, speed))
    assert [row["rank"] for row in found] == [1, 2, 4, 4]
    assert found[0]["margin"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("ratio", [0.95, 1.05])
def test_a_little_off_it_the_rank_is_full_and_the_margin_small(ratio):
    found = observer_datasets.neutral_steer((ratio, 25.0))
    assert [row["rank"] for row in found] == [2, 2, 4, 4]
    assert 0.005 < found[0]["margin"] < 0.05


@pytest.mark.slow
def test_the_observers_follow_the_paper_s_test_and_fast_steer():
    found = {row["observer"]: row for row in observer_datasets.driven_test(3)}
    assert found["two-stage, Kalman"]["correlation"] > 0.98
    assert found["eq (3)"]["torque_miss"] > found["disturbance observer"]["torque_miss"]
    errors = {row["observer"]: row["error"] for row in observer_datasets.side_by_side(("brush tyres", "25 m/s", 21))}
    assert errors["two-stage, Kalman"] < 0.05 < errors["conventional, poles x10"]


def against(announced):
    share = np.clip((TIME - 15.0) / 2.0, 0.0, 1.0)
    ahead = np.where(announced <= TIME, 1.0, 0.0)
    drive = SimpleNamespace(time=TIME, truth=lambda name: 2790.0 * share)
    return combined_datasets.against_the_peak(drive, {"limit_ahead": ahead})


def test_a_peak_is_announced_before_it_or_never():
    early = against(16.0)
    assert early.peak - early.announced == pytest.approx(0.96, abs=0.02)
    assert against(math.inf).announced == math.inf


def test_false_ice_and_false_announcements_are_those_of_the_road(monkeypatch):
    road = np.where(TIME < 10.0, 1.0, 0.35)
    truths = {"road_friction": road, "front_lateral_force": 0.3 * 7900.0 * road}
    estimate = {
        "friction": np.where((TIME >= 2.0) & (TIME < 3.0), 0.5, road),
        "limit_ahead": np.where(TIME < 0.5, 1.0, 0.0),
    }
    drive = SimpleNamespace(time=TIME, truth=truths.__getitem__)
    monkeypatch.setattr(combined_datasets, "on", lambda name, seed: drive)
    monkeypatch.setattr(combined_datasets, "estimated", lambda drive, readings: estimate)
    row, _ = combined_datasets.quiet(("mixed", 1))
    assert (row["ice"], row["announced"], row["seconds"]) == pytest.approx((1.0, 0.5, 20.0))


def test_beliefs_change_what_they_say_and_nothing_else():
    car = from_file()
    wrong = both_stiff(car)
    changed = {name for name in type(car).__dataclass_fields__ if getattr(car, name) != getattr(wrong, name)}
    assert changed == {FRONT, REAR}
    assert getattr(wrong, FRONT) == pytest.approx(1.2 * getattr(car, FRONT))
    assert general(car).mass == car.mass
    assert general(car).front_force_shape != car.front_force_shape


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


def test_a_slow_car_without_accelerometer_never_starts_anew_and_beats_geometry():
    (row,) = combined_datasets.slow(("small car, 1050 kg", 8.0, 5))
    assert row["restarts"] == 0.0
    assert row["rms"] < 0.4
    assert row["over_kinematics"] < 1.0
    assert row["covered"] > 0.9


def test_a_yaw_rate_that_sticks_does_not_carry_an_adapted_filter_away():
    small = combined_datasets.small_cars()["small car, 1050 kg"]
    drive, car = combined_datasets.slow_drive(small.chassis, 8.0, 5), combined_datasets.brochure(small)
    rate = drive["yaw_rate"]
    stuck = np.where((rate.time > 20.0) & (rate.time < 25.0), 1.5, rate.values)
    seen = beside_truth(drive.with_channels([dataclasses.replace(rate, values=stuck)]), car)
    while_stuck = (seen.time > 20.0) & (seen.time < 25.5)
    assert seen.result["estimate.restarted"][while_stuck].sum() >= 1.0
    assert not seen.result["estimate.restarted"][~while_stuck].any()
    assert seen.figures(45.0).rms < math.radians(0.4)


def test_without_recordings_nothing_is_measured(monkeypatch, tmp_path):
    monkeypatch.setenv("TIEROD_DATA", str(tmp_path))
    assert real_datasets.race_laps(False) == real_datasets.car_park(None) == real_datasets.blocks(2) == []
    assert real_datasets.unprepared("race laps") == []


def test_a_passenger_car_is_estimated_as_well_as_by_geometry_and_unprepared_better_than_by_simple_means(monkeypatch):
    monkeypatch.setenv("TIEROD_DATA", str(shared_data("revsted_slip_angle").parent))
    found = {row["estimator"]: row for row in real_datasets.car_park(None)}
    assert found["combined"]["rms"] < 1.1 * found["geometry, gyroscope"]["rms"] < 0.22
    (typed,) = [row for row in real_datasets.unprepared("passenger car") if row["estimate"] == "typical"]
    assert typed["over_fitted"] < 1.3
    assert typed["over_simple"] < 1.0


@pytest.mark.slow
def test_race_laps_and_a_block_with_a_file_of_those_before(monkeypatch):
    monkeypatch.setenv("TIEROD_DATA", str(shared_data("ferrari_250lm_race").parent))
    found = {row["estimator"]: row for row in real_datasets.race_laps(False)}
    assert found["combined"]["rms"] < 0.2 < found["linear Kalman filter, fixed stiffness"]["rms"]
    whole, *strata = real_datasets.blocks(3)
    assert whole["rms"] < 0.25
    assert sum(row["samples"] for row in strata) == 2 * whole["samples"]


def recording(**values):
    return Recording(
        {name: Channel(name, TIME, np.broadcast_to(value, TIME.shape), "") for name, value in values.items()}
    )


def test_the_leaky_integral_follows_its_equation():
    block = typical_cars.LeakyKinematic(0.01, 1.5)
    out = scan(block, np.tile([20.0, 0.1, 3.0], (3000, 1))).values[:, 0]
    assert out[-1] == pytest.approx((3.0 - 2.0) * 1.5 / 20.0, rel=1e-6)  # v' = 0 where a - r V = v / leak
    reached = np.flatnonzero(out > out[-1] * (1.0 - math.exp(-1.0)))[0] * 0.01
    assert reached == pytest.approx(1.5, abs=0.03)


def test_geometry_finds_the_distance_that_made_the_truth():
    rate, speed = 0.3 * np.sin(TIME), 5.0
    made = recording(
        yaw_rate=rate,
        vehicle_speed=speed,
        sideslip_angle=1.2 * rate / speed,
    )
    seen = typical_cars.geometric(made, 10.0)
    np.testing.assert_allclose(seen.estimate, seen.truth, atol=1e-12)


def test_a_linear_car_is_found_by_the_linear_filter():
    car = load("ferrari-250lm")
    steer = 0.02 * np.sin(2.0 * TIME)
    stiffness = {"front": 7e4, "rear": 1.1e5}
    tuned = typical_cars.LINEAR_START | stiffness
    block = typical_cars.linear_filter(car, tuned)
    quiet = np.column_stack([steer, np.full(len(TIME), 25.0), np.full((len(TIME), 2), np.nan)])
    out = scan(block, quiet)
    made = recording(
        road_wheel_angle=steer,
        vehicle_speed=25.0,
        yaw_rate=out["mean.yaw_rate"],
        lateral_acceleration=np.gradient(out["mean.sideslip_angle"], 0.01) * 25.0 + 25.0 * out["mean.yaw_rate"],
        sideslip_angle=out["mean.sideslip_angle"],
    )
    found = typical_cars.linear(made, car, 10.0)
    spread = float(np.std(found.truth))
    assert found.figures(10.0).rms < 0.05 * spread
