import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.courses.catalogue import WayTable
from tierod_lab.ground.courses.lane import Slalom, SteadyCircle
from tierod_lab.ground.courses.open_loop import (
    AngleRamp,
    LockToLock,
    RandomSteer,
    SineSteer,
    SteadyAngle,
    StepSteer,
)


def test_a_step_has_its_rate_and_height():
    course = StepSteer(settle=2.0, angle=-0.6, rate=6.0, hold=4.0, rest=1.0)
    assert course.angle_at(np.array([0.0, 2.0, 2.05, 2.1, 6.0])) == pytest.approx([0.0, 0.0, -0.3, -0.6, -0.6])
    assert course.duration == pytest.approx(2.0 + 0.1 + 4.0 + 1.0)


def test_a_sine_begins_and_ends_at_zero():
    course = SineSteer(settle=1.0, amplitude=0.5, frequency=0.5, periods=2, rest=1.0)
    time = np.linspace(0.0, course.duration, 601)
    inside = (time > 1.0) & (time < 5.0)
    assert np.allclose(course.angle_at(time)[inside], 0.5 * np.sin(math.pi * (time[inside] - 1.0)))
    assert np.allclose(course.angle_at(time)[~inside], 0.0, atol=1e-12)
    assert course.duration == 6.0


def test_a_sine_dwells_at_its_last_extreme():
    course = SineSteer(settle=0.0, amplitude=0.5, frequency=1.0, periods=1, dwell=0.5)
    time = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.375, 1.5, 1.6])
    expected = [0.5, 0.0, -0.5, -0.5, -0.5, -0.5 * math.sqrt(0.5), 0.0, 0.0]
    assert course.angle_at(time) == pytest.approx(expected, abs=1e-12)


def test_random_steering_has_its_band_and_size():
    course = RandomSteer(settle=0.0, deviation=0.2, lowest=0.5, highest=1.5, time=200.0, rest=0.0)
    time = np.arange(0.0, 200.0, 0.01)
    angle = course.angle_at(time)
    power, frequency = np.abs(np.fft.rfft(angle)) ** 2, np.fft.rfftfreq(len(time), 0.01)
    assert np.std(angle) == pytest.approx(0.2, rel=0.02)
    assert np.sum(power[(frequency > 0.45) & (frequency < 1.55)]) > 0.99 * np.sum(power)


def test_a_ramp_of_angle_ends_at_its_angle():
    course = AngleRamp(settle=1.0, angle=1.0, rate=0.1, rest=2.0)
    assert course.angle_at(np.array([1.0, 6.0, 11.0, 13.0])) == pytest.approx([0.0, 0.5, 1.0, 1.0])
    assert course.duration == pytest.approx(13.0)


def test_speed_rises_with_the_wheel_held():
    course = SteadyAngle(angle=0.4, turning=2.0, first_speed=5.0, last_speed=10.0, rise=0.5, settle=4.0)
    time = np.array([0.0, 1.0, 3.0, 9.0, 14.0, 20.0])
    speed, acceleration = course.speed_at(time)
    assert speed == pytest.approx([5.0, 5.0, 5.0, 7.5, 10.0, 10.0])
    assert list(acceleration) == [0.0, 0.0, 0.0, 0.5, 0.0, 0.0]
    assert course.angle_at(time) == pytest.approx([0.0, 0.2, 0.4, 0.4, 0.4, 0.4])


def test_lock_to_lock_visits_both_locks_and_rests():
    course = LockToLock(lock_angle=9.0, rate=1.0, rest=2.0)
    time = np.arange(0.0, course.duration, 1e-3)
    angle = course.angle_at(time)
    rate = np.gradient(angle, 1e-3)
    assert (angle.min(), angle.max()) == (pytest.approx(-9.0), pytest.approx(9.0))
    assert np.max(np.abs(rate)) == pytest.approx(1.0, rel=1e-3)
    assert np.argmin(angle) < np.argmax(angle), "to the right first"
    assert angle[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.sum(np.abs(rate) < 1e-9) * 1e-3 == pytest.approx(4 * 2.0, abs=0.05)
    # Strokes of 9, 18, 9 rad; half a cosine takes pi/2 times as long as its greatest rate would.
    assert course.duration == pytest.approx(0.5 * math.pi * 36.0 + 4 * 2.0)


@pytest.mark.parametrize("load", [0.0, 1.0])
def test_a_hoist_takes_the_load_off(load):
    columns = LockToLock(load=load).columns(np.zeros(2), np.zeros(2), 0.0, 0.0)
    assert list(columns["road.support"]) == [load, load]
    assert list(columns["demand.attention"]) == [0.0, 0.0], "no driver follows a lane"


@pytest.mark.parametrize(
    ("course", "given", "said"),
    [
        (RandomSteer, {"time": 1.0, "lowest": 0.2, "highest": 0.9}, "no band that 1 s could show"),
        (RandomSteer, {"lowest": 2.0, "highest": 1.0}, "give the lower one first"),
        (SineSteer, {"periods": 0}, "a test cannot have 0 periods"),
        (SteadyAngle, {"first_speed": 20.0, "last_speed": 10.0}, "give a last_speed above the first_speed"),
        (SteadyCircle, {"first_speed": 20.0, "last_speed": 20.0}, "give a last_speed above the first_speed"),
        (SteadyCircle, {"radius": 0.0}, "radius 0 cannot be driven"),
        (Slalom, {"cones": 0}, "a test cannot have 0 cones"),
        (WayTable, {"laps": 0}, "a test cannot have 0 laps"),
    ],
)
def test_a_test_that_cannot_be_is_refused(course, given, said):
    with pytest.raises(ParameterError, match=said):
        course(**given)
