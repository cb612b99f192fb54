import math
from functools import lru_cache

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground import EpsCar, FrictionCourse, SensorSet, drive, lock_to_lock
from tierod_lab.ground.run import CHANNELS


def level(course, *time):
    change = course.behaviour().change(np.array(time), None)
    assert change.gain == 0.0
    return change.offset


def test_constant_step_and_straight_rise():
    time = (0.0, 9.999, 10.0, 15.0, 20.0, 30.0)
    np.testing.assert_array_equal(level(FrictionCourse.constant(4.0), *time), 4.0)
    np.testing.assert_array_equal(level(FrictionCourse.step(4.0, 8.0, 10.0), *time), [4, 4, 8, 8, 8, 8])
    np.testing.assert_array_equal(level(FrictionCourse.step(4, 8, 10), *time), [4, 4, 8, 8, 8, 8])
    np.testing.assert_allclose(level(FrictionCourse((10.0, 20.0), (4.0, 8.0)), *time), [4, 4, 4, 6, 8, 8])


CANONICAL = CHANNELS
IDEAL = SensorSet.ideal().only(CHANNELS)


def same(one, other, names=CANONICAL):
    return all(np.array_equal(one[name].values, other[name].values) for name in names)


def test_seed_keeps_the_route_whatever_else_changes():
    one = drive(minutes=1.2, friction=4.0, seed=5)
    other = drive(minutes=1.2, friction=12.5, seed=5, scatter=True, sensors=IDEAL)
    truth = drive(minutes=1.2, friction=4.0, seed=5, sensors=IDEAL)
    assert one.metadata["stretches"] == other.metadata["stretches"]
    assert np.max(np.abs(truth["truth_distance"].values - other["truth_distance"].values)) < 5.0
    assert not same(truth, other, ["driver_torque"])


def test_friction_step_comes_at_its_time():
    recording = drive(minutes=2.0, friction=FrictionCourse.step(4.0, 12.5, 60.0), seed=2)
    level, time = recording["truth_friction_torque"].values, recording["truth_friction_torque"].time
    assert np.all(level[time < 60.0] == 4.0)
    assert np.all(level[time >= 60.0] == 12.5)
    resistance = np.abs(recording["truth_friction_resistance"].values)
    assert np.max(resistance[time < 60.0]) <= 4.0
    assert np.max(resistance) == pytest.approx(12.5, rel=0.02)


def test_measured_is_truth_with_noise_and_bias():
    truth = drive(minutes=2.0, seed=4, sensors=IDEAL)
    measured = drive(minutes=2.0, seed=4)
    sensors = SensorSet.production()
    for name in CANONICAL:
        error = measured[name].values - truth[name].values
        noise = math.hypot(sensors[name].noise, sensors[name].quantum / math.sqrt(12.0))
        assert np.mean(error) == pytest.approx(sensors[name].bias, abs=5.0 * noise / math.sqrt(len(error)))
        assert np.std(error) == pytest.approx(noise, rel=0.03)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"minutes": 0.0}, "positive duration"),
        ({"minutes": math.nan}, "positive duration"),
        ({"friction": -1.0}, "not negative"),
    ],
)
def test_wrong_options_are_refused_in_a_sentence(options, message):
    with pytest.raises(ParameterError, match=message):
        drive(**({"minutes": 0.1, "seed": 0} | options))


def resistance(recording):
    steering = EpsCar().steering
    gear, damping = steering.motor.ratio, steering.damping + steering.motor.ratio**2 * steering.motor.damping
    rate = recording["steering_wheel_rate"].values
    return rate, recording["driver_torque"].values + gear * recording["motor_torque"].values - damping * rate


def loop_friction(recording):
    """Friction from the work over the closed turn, Mohtat et al., eqs (15) to (17)."""
    rate, torque = resistance(recording)
    assert np.allclose(np.diff(recording["steering_wheel_rate"].time), 0.01)
    return np.sum(torque * rate) / np.sum(np.abs(rate))


@lru_cache(maxsize=8)
def turned(friction, hoist):
    return loop_friction(lock_to_lock(friction, hoist, sensors=IDEAL))


@pytest.mark.parametrize("hoist", [True, False])
@pytest.mark.parametrize("added", [1.5, pytest.param(4.0, marks=pytest.mark.slow), 8.5])
def test_lock_to_lock_shows_the_added_friction(hoist, added):
    base = turned(4.0, hoist)
    assert turned(4.0 + added, hoist) - base == pytest.approx(added, abs=0.1)
    assert hoist == (base < 4.05)
