"""Signals of the wrong sign beside the others."""

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.io.signs import COMPARED, sign_warnings

RANDOM = np.random.default_rng(4)
TIME = np.arange(0.0, 60.0, 0.01)


def turns(name: str, scale: float, noise: float = 0.0) -> Channel:
    shape = np.sin(0.7 * TIME) + 0.5 * np.sin(1.9 * TIME)
    return Channel(name, TIME, scale * shape + noise * RANDOM.normal(size=len(TIME)), SIGNALS[name].unit)


def drive(**signs: float) -> Recording:
    scales = {
        "steering_wheel_angle": 0.8,
        "yaw_rate": 0.2,
        "lateral_acceleration": 3.0,
        "driver_torque": 2.0,
        "motor_torque": 1.5,
    }
    channels = [turns(name, signs.get(name, 1.0) * scale, 0.1 * scale) for name, scale in scales.items()]
    channels.append(Channel("vehicle_speed", TIME, np.full(len(TIME), 15.0), "m/s"))
    return Recording({channel.name: channel for channel in channels})


def test_right_signs_earn_no_warning():
    assert sign_warnings(drive()) == ()


@pytest.mark.parametrize("wrong", ["steering_wheel_angle", "yaw_rate", "lateral_acceleration"])
def test_the_odd_one_is_named(wrong):
    (warning,) = sign_warnings(drive(**{wrong: -1.0}))
    assert warning.startswith(f"{wrong} probably has the wrong sign (in turns")


def test_torques_against_each_other():
    (warning,) = sign_warnings(drive(motor_torque=-1.0))
    assert warning.startswith("driver_torque or motor_torque probably has the wrong sign")


def test_a_speed_of_the_wrong_sign_blames_nothing_else():
    backwards = Channel("vehicle_speed", TIME, np.full(len(TIME), -15.0), "m/s")
    (warning,) = sign_warnings(drive().with_channels([backwards]))
    assert warning.startswith("vehicle_speed is negative for 100 % of the driving time")


def test_a_rate_against_its_angle():
    whole, rate = drive(), 0.8 * (0.7 * np.cos(0.7 * TIME) + 0.95 * np.cos(1.9 * TIME))
    for sign, count in ((1.0, 0), (-1.0, 1)):
        channel = Channel("steering_wheel_rate", TIME, sign * rate, "rad/s")
        warnings = sign_warnings(whole.with_channels([channel]))
        assert len(warnings) == count
        assert all("steering_wheel_rate or steering_wheel_angle probably has" in warning for warning in warnings)


def test_two_signals_are_both_named():
    whole = drive(yaw_rate=-1.0)
    pair = Recording({name: whole[name] for name in ("yaw_rate", "lateral_acceleration")})
    (warning,) = sign_warnings(pair)
    assert warning.startswith("yaw_rate or lateral_acceleration probably has the wrong sign")


@pytest.mark.parametrize(("first", "warned"), [(1.0, False), (-1.0, True)])
def test_the_first_hour_decides_however_long_the_recording_is(first, warned):
    time = np.arange(0.0, 4.0 * COMPARED, 0.1)
    shape = np.sin(0.7 * time) + 0.5 * np.sin(1.9 * time)
    sign = np.where(time < COMPARED, first, -first)
    channels = (
        Channel("yaw_rate", time, 0.2 * sign * shape, "rad/s"),
        Channel("lateral_acceleration", time, 3.0 * shape, "m/s**2"),
        Channel("odometer", np.array([0.0, 1e9]), np.zeros(2), "m"),
    )
    assert bool(sign_warnings(Recording({channel.name: channel for channel in channels}))) is warned


def test_straight_driving_says_nothing():
    noise = {name: turns(name, 0.0, 0.001) for name in ("yaw_rate", "lateral_acceleration")}
    assert sign_warnings(Recording(noise)) == ()
    assert sign_warnings(Recording({})) == ()
