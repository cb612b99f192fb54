"""Open-loop and bench tests, and conditions of road, wind and hands."""

import math

import numpy as np
import pytest

from tierod_lab.ground.courses.bench import BenchMultisine, BenchRamps, BenchSweep
from tierod_lab.ground.courses.course import (
    During,
)
from tierod_lab.ground.courses.manoeuvres import LockToLock, RandomSteer


def test_random_steering_has_its_band_and_size():
    course = RandomSteer(settle=0.0, deviation=0.2, lowest=0.5, highest=1.5, time=200.0, rest=0.0)
    time = np.arange(0.0, 200.0, 0.01)
    angle = course.angle_at(time)
    power, frequency = np.abs(np.fft.rfft(angle)) ** 2, np.fft.rfftfreq(len(time), 0.01)
    assert np.std(angle) == pytest.approx(0.2, rel=0.02)
    assert np.sum(power[(frequency > 0.45) & (frequency < 1.55)]) > 0.99 * np.sum(power)


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


TIME = np.arange(0.0, 20.0, 0.01)
PLACE = 10.0 * TIME


def test_a_ramp_is_smooth_and_symmetric():
    share = During(5.0, 9.0, ramp=1.0).share(TIME, PLACE)
    assert share[TIME.searchsorted(5.5)] == pytest.approx(0.5, abs=0.01)
    assert np.all(share[(TIME > 6.01) & (TIME < 7.99)] == 1.0)
    assert np.max(np.abs(np.diff(share))) <= 1.5 * 0.01 + 1e-9, "steepest in the middle of the ramp"
    inside = (TIME > 5.0) & (TIME < 9.0)
    assert np.all(share[~inside] == 0.0)
    assert np.allclose(share[inside], np.flip(share[inside]), atol=2e-2)


def frequency(sweep, at):
    time = np.arange(at - 0.5, at + 0.5, 1e-4)
    torque = sweep.columns(time, 0.0 * time, 0.0, 0.0)["motor_torque"]
    up = time[1:][(torque[:-1] < 0.0) & (torque[1:] >= 0.0)]
    return (len(up) - 1) / (up[-1] - up[0])


def test_the_sweep_passes_its_frequencies_at_an_even_pace_of_octaves():
    sweep = BenchSweep(amplitude=0.5, lowest=4.0, highest=32.0, settle=1.0, time=31.0)
    assert [frequency(sweep, at) for at in (11.0, 21.0)] == pytest.approx([8.0, 16.0], rel=0.03)
    time = np.linspace(0.0, 31.0, 5000)
    torque = sweep.columns(time, time, 0.0, 0.0)["motor_torque"]
    assert np.all(torque[time < 1.0] == 0.0)
    assert np.max(np.abs(torque)) == pytest.approx(0.5, rel=1e-3)


def torque_of(test):
    time = np.arange(0.0, test.duration, 1e-3)
    return time, test.columns(time, time, 0.0, 0.0)["motor_torque"]


def test_ramps_are_straight_and_grow():
    time, torque = torque_of(BenchRamps(amplitude=0.4, period=4.0, first=0.25, settle=1.0, time=21.0))
    assert np.all(torque[time < 1.0] == 0.0)
    assert np.max(torque[time < 5.0]) == pytest.approx(0.4 * (0.25 + 0.75 * 1.0 / 20.0), rel=1e-3)
    assert np.max(np.abs(torque)) == pytest.approx(0.4 * (0.25 + 0.75 * 19.0 / 20.0), rel=1e-3)
    assert np.max(np.abs(np.diff(torque, 2)[(time[1:-1] > 1.1) & (time[1:-1] < 1.9)])) < 1e-6


def test_a_multisine_has_the_power_of_one_sine_and_no_high_peak():
    _, torque = torque_of(BenchMultisine(amplitude=0.3, settle=0.0, time=60.0))
    assert np.std(torque) == pytest.approx(0.3 / math.sqrt(2.0), rel=0.02)
    assert np.max(np.abs(torque)) < 4.0 * np.std(torque)
