"""Hysteresis is noticed where it is, and not where it is not, whatever the torques' unit."""

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.errors import InputError
from tierod.io.readers import read
from tierod.methods.identification.hysteresis_presence import HysteresisPresenceTest
from tierod_lab.ground import drive

NAMES = (
    "steering_wheel_angle",
    "steering_wheel_rate",
    "driver_torque",
    "motor_torque",
    "lateral_acceleration",
)


def outcome(recording, gain=1.0):
    aligned = recording.align(NAMES, 50.0)
    signals = dict(zip(NAMES, aligned.values.T, strict=True))
    signals["driver_torque"] = gain * signals["driver_torque"]
    return HysteresisPresenceTest().test(aligned.time, **signals)


@pytest.mark.parametrize("seed", [3, *(pytest.param(each, marks=pytest.mark.slow) for each in (4, 5))])
@pytest.mark.parametrize("friction", [2.0, *(pytest.param(each, marks=pytest.mark.slow) for each in (4.0, 8.0))])
def test_friction_is_noticed_in_two_minutes(seed, friction):
    found = outcome(drive(minutes=2.0, friction=friction, seed=seed), gain=250.0)
    assert found.present, found
    assert found.share > 0.5


@pytest.mark.parametrize("seed", [3, 4, *(pytest.param(each, marks=pytest.mark.slow) for each in (5, 6))])
def test_without_friction_nothing_is_noticed(seed):
    found = outcome(drive(minutes=2.0, friction=1e-3, seed=seed))
    assert not found.present, found


def test_the_highway_minute_carries_hysteresis():
    log = shared_data("rav4_highway_minute", "can.log")
    found = outcome(read(log, dbc="rav4", channel_map="rav4", names=NAMES))
    assert found.present
    assert found.share == pytest.approx(0.2, abs=0.05)


def test_the_unit_of_the_torque_does_not_matter():
    recording = drive(minutes=1.0, seed=3)
    assert outcome(recording, 100.0).share == pytest.approx(outcome(recording).share, rel=1e-9)


def test_what_cannot_be_tested_is_refused():
    time = np.arange(0.0, 60.0, 0.02)
    zeros = np.zeros_like(time)
    with pytest.raises(InputError, match="constant"):
        HysteresisPresenceTest().test(time, zeros, zeros, zeros, zeros, zeros)
    with pytest.raises(InputError, match="at least 20 s"):
        HysteresisPresenceTest().test(time[:100], *(zeros[:100],) * 5)
