"""The combined sideslip estimator beside the virtual car, and on what it must survive."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.signal import lfilter

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.estimators.linear_algebra import diagonal, from_diagonal
from tierod.models.lateral_parameters import LateralParameters
from tierod.monitors.sideslip.estimator import (
    FARTHEST_SHOWN,
    SMOOTHING,
    USUAL_SLIP,
    CombinedSample,
    CombinedSideslip,
    identifiability,
)
from tierod.monitors.sideslip.tuning import CombinedTuning, GripLimit, Wandering, bounded
from tierod.vehicles import load
from tierod_lab.ground import Sensor, SensorSet, run
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.courses.open_loop import RandomSteer

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

STEP = 0.01
RATE = 1.0 / STEP
NOISE = {
    "vehicle_speed": 0.02,
    "road_wheel_angle": 2e-4,
    "yaw_rate": 0.003,
    "lateral_acceleration": 0.1,
    "longitudinal_acceleration": 0.1,
    "road_wheel_torque": 1.0,
}
COLUMN = {name: k for k, name in enumerate(CombinedSample._fields)}


@pytest.fixture(scope="module")
def drive():
    """Random steering at 25 m/s: samples, true sideslip angle [rad]."""
    sensors = SensorSet({name: Sensor(noise=noise, rate=RATE) for name, noise in NOISE.items()})
    course = RandomSteer(speed=25.0, deviation=math.radians(14.0), lowest=0.1, highest=1.0, time=40.0, seed=7)
    recording = run(catalogue.load("steer-by-wire").block, course, seed=7, sensors=sensors).recording
    truth = recording["truth_sideslip_angle"]
    samples = np.column_stack([recording[name].values for name in CombinedSample._fields])
    return samples, np.interp(recording["yaw_rate"].time, truth.time, truth.values)


def estimator(steering=True, front=1.0, rear=1.0, **tuning):
    car = load("steer-by-wire").parameters_for(LateralParameters)
    wrong = dataclasses.replace(
        car,
        front_cornering_stiffness=front * car.front_cornering_stiffness,
        rear_cornering_stiffness=rear * car.rear_cornering_stiffness,
    )
    return CombinedSideslip.of_parameters(wrong, STEP, CombinedTuning(**tuning), steering)


def error(result, truth, start=20.0):
    """Root mean square error of the sideslip angle after a while [deg]."""
    return math.degrees(np.sqrt(np.mean((result["sideslip_angle"] - truth)[round(start / STEP) :] ** 2)))


@pytest.mark.parametrize("steering", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_wrong_stiffnesses_are_learnt(drive, steering):
    samples, truth = drive
    result = scan(estimator(steering, 1.2, 1.2), samples)
    assert error(result, truth) < 0.05
    assert result["front_stiffness"][-1] == pytest.approx(1.0 / 1.2, rel=0.05)
    assert result["rear_stiffness"][-1] == pytest.approx(1.0 / 1.2, rel=0.05)
    inside = np.abs(result["sideslip_angle"] - truth) < 1.96 * result["sideslip_angle_deviation"]
    assert np.mean(inside[2000:]) > 0.9


def test_it_runs_with_what_is_left_of_the_signals(drive):
    samples, truth = drive
    poor = samples.copy()
    for name in ("lateral_acceleration", "longitudinal_acceleration", "road_wheel_torque"):
        poor[:, COLUMN[name]] = np.nan
    assert error(scan(estimator(), poor), truth) < 0.1


def gone(samples, first, last, **values):
    """The samples with some signals exchanged for a while."""
    changed = samples.copy()
    for name, value in values.items():
        changed[first:last, COLUMN[name]] = value
    return changed


@pytest.mark.parametrize(
    "values",
    [
        {"vehicle_speed": np.nan},
        {"vehicle_speed": 0.0},
        dict.fromkeys(CombinedSample._fields, np.nan),
    ],
)
@pytest.mark.parametrize("steering", [True, False])
def test_without_a_forward_speed_the_last_estimate_is_held_and_its_variance_grows(drive, values, steering):
    samples, truth = drive
    result = scan(estimator(steering), gone(samples, 1500, 1800, **values))
    assert np.isfinite(result.values).all()
    held = slice(1500, 1800)
    assert (result["held"][held] == 1.0).all()
    assert np.ptp(result["sideslip_angle"][held]) == 0.0
    growth = np.diff(result["sideslip_angle_deviation"][held])
    assert (growth >= 0.0).all()
    assert (growth[:150] > 0.0).all()
    assert result["held"][1800] == 0.0
    assert error(result, truth, 25.0) < 0.05


@pytest.mark.parametrize("steering", [True, False])
def test_after_reversing_the_estimate_begins_anew(drive, steering):
    samples, truth = drive
    block = estimator(steering)
    result = scan(block, gone(samples, 1500, 1800, vehicle_speed=-3.0))
    reverses = slice(1500, 1800)
    assert (result["held"][reverses] == 1.0).all()
    assert (result["restarted"][reverses] == 0.0).all()
    assert (result["sideslip_angle"][reverses] == 0.0).all()
    assert (result["front_stiffness_identified"][reverses] == 0.0).all()
    assert error(result, truth, 25.0) < 0.05


def test_nothing_is_announced_while_held(drive):
    samples, _ = drive
    nothing = GripLimit(slowest=1e-9, acceleration=1e-9, force=-10.0, tight=1e9)
    easily = dataclasses.replace(
        estimator(), limit_share=1e-6, limit_rule=HeldThreshold(1e-9, 1, "upper"), limit=nothing
    )
    result = scan(easily, gone(samples, 1500, 1600, vehicle_speed=0.0))
    assert (result["limit_ahead"][1400:1500] == 1.0).all()
    assert not result["limit_ahead"][1500:1600].any()


def test_it_begins_with_nothing():
    empty = np.full((50, len(COLUMN)), np.nan)
    result = scan(estimator(), empty)
    assert np.isfinite(result.values).all()
    assert (result["sideslip_angle"] == 0.0).all()
    assert (result["held"] == 1.0).all()


def test_it_starts_anew_where_it_is_lost(drive):
    samples, truth = drive
    lost = gone(samples, 1000, 1300, yaw_rate=1.5, lateral_acceleration=-9.0)
    result = scan(estimator(), lost)
    assert result["restarted"][:1000].sum() == 0.0
    assert result["restarted"][1000:1500].sum() >= 1.0
    assert error(result, truth, 30.0) < 0.1


def test_friction_stays_above_what_the_acceleration_shows(drive):
    samples, _ = drive
    result = scan(estimator(log_friction=Wandering(0.6, 1.0, usual=-3.0)), samples)
    share = STEP / (SMOOTHING + STEP)
    smooth = np.abs(lfilter([share], [1.0, share - 1.0], samples[:, COLUMN["lateral_acceleration"]]))
    assert (result["friction"] > 0.999 * np.minimum(smooth / (1.06 * 9.81 * 0.95), 1.0)).all()


def test_nothing_need_be_followed(drive):
    samples, truth = drive
    nothing = dict.fromkeys(
        (
            "log_front_stiffness",
            "log_rear_stiffness",
            "log_friction",
            "bank_angle",
            "side_force",
            "side_moment",
            "log_steering_friction",
            "log_trail",
        )
    )
    result = scan(estimator(False, **nothing), samples)
    assert error(result, truth) < 0.05
    assert (result["front_stiffness"] == 1.0).all()
    assert (result["front_stiffness_identified"] == 0.0).all()


def test_what_a_drive_shows_is_said(drive):
    samples, _ = drive
    block = estimator(False)
    found = identifiability(block, scan(block, samples).state)
    assert {"log_front_stiffness", "log_rear_stiffness"} <= set(found.identified)
    assert found.shares["log_front_stiffness"] > 0.95
    assert "front stiffness" in str(found)
    assert "side force" in found.least
    assert found.left > 0.5


def test_at_the_start_nothing_is_reported():
    block = estimator(False)
    found = identifiability(block, block.init())
    assert found.identified == ()
    assert found.left == pytest.approx(1.0)
    assert str(found).startswith("The drive identifies none of the unknowns.")


@pytest.mark.parametrize("step", [0.0, -0.01, 0.1, math.nan])
def test_a_sample_time_that_cannot_be_is_refused(step):
    with pytest.raises(ParameterError, match="sample time"):
        CombinedSideslip.of_vehicle(load("steer-by-wire"), step)


def test_the_vehicle_file_decides_on_the_steering():
    assert CombinedSideslip.of_vehicle(load("steer-by-wire"), STEP).filter.model.steering
    assert not CombinedSideslip.of_vehicle(load("midsize-eps"), STEP).filter.model.steering


@pytest.mark.parametrize("lateral", [4.0, -4.0])
def test_friction_is_at_least_what_the_acceleration_shows_less_what_the_roll_adds_to_it(lateral):
    """A body that leans adds `roll_share` of the acceleration to the reading: mu >= a / (1 + share) / g."""
    block = estimator()
    car = block.filter.parameters.car
    assert car.roll_share > 0.01
    mean = block.filter.init().mean._replace(log_friction=-3.0)
    kept = bounded(block.filter, mean, lateral)
    least = abs(lateral) / (1.0 + car.roll_share) / 9.80665 / car.tyre_friction
    assert kept.log_friction == pytest.approx(math.log(least), rel=1e-3)
    assert bounded(block.filter, mean._replace(log_friction=-0.1), lateral).log_friction == -0.1


def test_far_from_the_limit_its_distance_is_below_zero(drive):
    """Random steering at 25 m/s on a dry road uses a part of the front axle's grip only."""
    distance = scan(estimator(), drive[0])["limit_distance"][2000:]
    assert np.median(distance) < 0.0
    assert distance.min() >= -FARTHEST_SHOWN


def test_raised_noises_bound_the_slip_of_the_rear_axle():
    """A second of readings of no slip, of six degrees together: Gaussian prior and reading, joined by hand."""
    block = CombinedSideslip.of_vehicle(load("midsize-eps"), STEP)
    start = block.init().belief
    names, speed, deviation = start.mean._fields, 10.0, 3.0
    place = names.index("lateral_speed")
    alone = [deviation**2 if name == "lateral_speed" else 0.0 for name in names]
    belief = start._replace(mean=start.mean._replace(lateral_speed=-3.0), covariance=from_diagonal(alone))
    after = belief
    for _ in range(round(1.0 / STEP)):
        after = block._within_usual_slip(after, speed, 1.0)
    left = USUAL_SLIP**2 / (USUAL_SLIP**2 + (deviation / speed) ** 2)
    assert after.mean.lateral_speed == pytest.approx(-3.0 * left)
    assert diagonal(after.covariance)[place] == pytest.approx(deviation**2 * left)
    unraised = block._within_usual_slip(belief, speed, 0.0)
    assert unraised.mean == belief.mean
    assert unraised.covariance == belief.covariance
