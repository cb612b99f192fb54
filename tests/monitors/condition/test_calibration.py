"""From healthy drives to parameters and limits: what is taken, what is refused, what is doubted, and what is kept."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.cli import main
from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.monitors.condition.calibration import calibrate_condition, calibrate_motion
from tierod.monitors.condition.definition import condition_monitor, rolling_limits
from tierod.monitors.condition.limits import (
    BLOCK,
    FACTOR,
    NAME,
    designed_on,
    limits_of,
    table_of,
)
from tierod.monitors.condition.parameters import calibrate
from tierod.monitors.condition.signals import OF_CARS, TARGETS, WHEELS, hypotheses, hypotheses_of_cars
from tierod.monitors.condition.vehicle_filter import SENSOR_NOISE, LeaveOutFilter
from tierod.report.identification import identify
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import Drive, calibration_drives, vehicle
from tierod_lab.papers.condition.recorded import recorded
from tierod_lab.papers.own_car.cars import drawn
from tierod_lab.papers.own_car.judging import driven

CAR = load("smartload")
COUNT = len(hypotheses()) - 1
PER_HOUR = 3600.0 / BLOCK


def made_up(speed, rate=100.0, times=None):
    """A recording of both rear wheel speeds."""
    time = np.arange(len(speed)) / rate if times is None else times
    return Recording({name: Channel(name, time, np.asarray(speed, float), "m/s") for name in WHEELS})


def with_targets(rate):
    time = np.arange(round(20.0 * rate)) / rate
    return made_up(driving(20.0)).with_channels(Channel(name, time, np.sin(time), "N*m") for name in TARGETS)


def driving(seconds, speed=5.0):
    return np.full(round(100.0 * seconds), speed)


@pytest.mark.parametrize(
    ("recordings", "message"),
    [
        ({"a": made_up(driving(400.0))}, "hold 6.7 minutes of driving, 1.5 of them for limits"),
        ({"a": made_up(driving(9.0)), "b": made_up(driving(9.0))}, "a and b hold the same drive"),
        ({"a": Recording({})}, "a has neither wheel_speed_rear_left nor"),
        ({"a": made_up(driving(20.0), rate=5.0)}, "at 5 Hz; calibration needs 10 Hz"),
        ({"a": with_targets(25.0)}, "a: the targets of the actuators are sampled at 25 Hz"),
    ],
)
def test_what_shows_too_little_is_refused_before_the_search(recordings, message):
    with pytest.raises(InputError, match=message):
        calibrate_condition(recordings, CAR)


def test_a_short_drive_and_a_vehicle_without_deviations_are_refused():
    with pytest.raises(InputError, match="better five minutes with bends"):
        calibrate([recorded(Drive("short-round", 24.0, 0, 5))], CAR)
    known = {name: replace(each, standard_deviation=None) for name, each in CAR.parameters.items()}
    with pytest.raises(InputError, match="gives no standard deviation"):
        calibrate([made_up(driving(70.0))], replace(CAR, parameters=known))


FRONT = "wheel_speed_front_left"


@pytest.fixture(scope="module")
def car():
    return drawn(0, 88002)


@pytest.fixture(scope="module")
def drive(car):
    whole = driven(car, 4.0, 88002)
    return Recording({name: whole[name] for name in OF_CARS})


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr("tierod.monitors.condition.limits.LEAST_HOURS", 0.04)


@pytest.mark.usefixtures("short")
def test_limits_are_found_written_and_read_by_the_monitor(car, drive, tmp_path):
    path = tmp_path / "mine.toml"
    values = [f"{name}={car.brochure[name]:g}" for name in ("mass", "wheelbase")]
    assert main(["new", str(path), "--class", "midsize", *values]) == 0
    begun = load(path)
    assert condition_monitor(begun).judge.decision.weighing.limits == rolling_limits()
    found = identify("thresholds", {"a": drive}, begun)
    assert not found.doubt
    found.write_vehicle(path)
    own = limits_of(load(path), hypotheses_of_cars())
    assert own.fast == pytest.approx(found.result.designed.limits.fast, rel=1e-4)
    assert condition_monitor(load(path)).judge.decision.weighing.limits == own
    usual = rolling_limits()
    assert own != usual
    pairs = zip((*own.fast, *own.slow), (*usual.fast, *usual.slow), strict=True)
    assert all(mine <= any_ + 1e-9 for mine, any_ in pairs), "its own quiet driving lowers limits alone"


@pytest.mark.usefixtures("short")
@pytest.mark.parametrize(("name", "size"), [(FRONT, 2.0), ("yaw_rate", 0.3)])
def test_a_drive_with_a_fault_is_named_and_nothing_may_be_used(car, drive, name, size):
    given = drive[name]
    values = given.values + np.where((given.time > 100.0) & (given.time < 110.0), size, 0.0)
    bad = drive.with_channels([Channel(name, given.time, values, given.unit)])
    assert f"b: {name}" in calibrate_motion({"a": drive.slice(stop=90.0), "b": bad}, car.brochure).doubt


@pytest.mark.usefixtures("short")
def test_too_few_sensors_and_too_little_driving_are_refused(car, drive):
    fewer = Recording({name: drive[name] for name in ("yaw_rate", FRONT, "wheel_speed_rear_left")})
    with pytest.raises(InputError, match="3 of the sensors.*it lacks.*steering_wheel_angle"):
        calibrate_motion({"a": fewer}, car.brochure)
    with pytest.raises(InputError, match="better an hour"):
        calibrate_motion({"a": drive.slice(stop=60.0)}, car.brochure)


def blocks(hours=20.0, scale=4.0, start=20.0, seed=3):
    """Ratios of every ten seconds, all alike but for one hypothesis that has an exponential tail above `start`."""
    count = round(hours * PER_HOUR)
    ratios = np.full((count, 2 * COUNT), 0.01)
    ratios[:, 4] = start + np.random.default_rng(seed).exponential(scale, count)
    return ratios


def test_the_factor_is_that_of_the_exponential_tail_and_never_below_the_least():
    scale, start, hours = 4.0, 20.0, 1e6
    found = designed_on(blocks(20.0, scale, start), hours)
    # The limit is where an exponential tail is exceeded once in so many hours: start + scale ln(blocks).
    assert found.limits.fast[4] == pytest.approx(start + scale * math.log(hours * PER_HOUR), rel=0.1)
    assert found.hours_between_alarms == pytest.approx(hours, rel=1e-6)
    short = designed_on(blocks(), 1.0)
    assert (short.factor, short.hours_between_alarms > 1.0) == (FACTOR, True)
    # Well above what was seen where that was next to nothing.
    assert (short.limits.fast[0], short.limits.slow[0]) == pytest.approx((2.01 * FACTOR, 1.01 * FACTOR))


def changed(**changes):
    return {NAME: {**table_of(designed_on(blocks(), 1000.0), "a drive"), **changes}}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({}, "no limits of the condition monitor; 'tierod identify thresholds'"),
        (changed(fast={"yaw_rate": 3.0}), "fast.*lacks 'wheel_speed_rear_left'"),
        (changed(fast={each.name: 1.0 for each in hypotheses()}), "holds unknown hypotheses"),
        (changed(slow={each.name: 0.0 for each in hypotheses()[1:]}), "numbers above zero"),
        (changed(gap="wide"), "numbers above zero"),
    ],
)
def test_a_table_that_cannot_be_meant_is_refused(table, message):
    with pytest.raises(ParameterError, match=message):
        limits_of(replace(CAR, thresholds=table))


@pytest.mark.slow
def test_five_minutes_distinguish_the_vehicle_and_its_sensors_from_the_nominal_ones():
    found = calibrate([recorded(calibration_drives(1)[0])], CAR)
    assert found.found.converged
    car, sensors = vehicle(1)
    left, right = sensors["wheel_speed_rear_left"].gain, sensors["wheel_speed_rear_right"].gain
    assert found.vehicle["mass"] == pytest.approx(car.chassis.mass, rel=0.02)
    assert found.vehicle["wheel_speed_scale"] == pytest.approx(0.5 * (left + right), rel=0.006)
    assert found.vehicle["wheel_speed_difference"] == pytest.approx(right / left - 1.0, abs=3e-4)
    assert found.vehicle["nominal_friction"] == pytest.approx(car.steering.rack.friction.level, rel=0.02)
    assert found.vehicle["rack_stiffness"] == pytest.approx(car.steering.rack.centring, rel=0.02)
    for name, close in (("yaw_rate", 5e-4), ("steering_shaft_torque", 0.01), ("tie_rod_force", 1.5)):
        assert found.vehicle[f"{name}_offset"] == pytest.approx(sensors[name].bias, abs=close)
    noise = LeaveOutFilter.of_vehicle(found.vehicle).sensor_noise
    assert noise.tie_rod_force == pytest.approx(SENSOR_NOISE.tie_rod_force, rel=0.01)
