"""A signal that is low-passed, held or late is named, or the signals of the torsion bar are said to contradict."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.signal import lfilter

from said import said
from tierod.core.recording import Channel, Recording
from tierod.monitors.diagnose import diagnose
from tierod_lab.ground.faults import AtTime, Fault
from tierod_lab.ground.faults.behaviours import Gain
from tierod_lab.ground.scenarios import load

BAR = Fault(element="driver_torque", behaviour=Gain(1.5), trigger=AtTime(5.0))


def recorded(*faults: Fault) -> Recording:
    scenario = dataclasses.replace(load("hands-off"), faults=()).with_run(None, 71)
    whole = dataclasses.replace(scenario, faults=faults).run().recording
    return Recording({name: each for name, each in whole.channels.items() if not name.startswith("truth_")})


@pytest.fixture(scope="module")
def fault_free() -> Recording:
    return recorded()


@pytest.fixture(scope="module")
def stiff() -> Recording:
    return recorded(BAR)


def low_passed(channel: Channel, cutoff: float) -> Channel:
    share = 1.0 - np.exp(-2.0 * np.pi * cutoff * np.median(np.diff(channel.time)))
    values, _ = lfilter([share], [1.0, share - 1.0], channel.values, zi=[(1.0 - share) * channel.values[0]])
    return dataclasses.replace(channel, values=values)


def held(channel: Channel, seconds: float) -> Channel:
    start = np.floor(channel.time / seconds) * seconds
    at = np.maximum(np.searchsorted(channel.time, start, side="right") - 1, 0)
    return dataclasses.replace(channel, values=channel.values[at])


def late(channel: Channel, seconds: float) -> Channel:
    at = np.maximum(np.searchsorted(channel.time, channel.time - seconds, side="right") - 1, 0)
    return dataclasses.replace(channel, values=channel.values[at])


@pytest.mark.parametrize(
    ("name", "change", "by"),
    [
        ("steering_wheel_angle", low_passed, 0.3),
        ("motor_angle_mechanical", low_passed, 0.3),
        ("driver_torque", low_passed, 0.3),
        ("motor_angle_mechanical", held, 1.0),
    ],
)
def test_a_smoothed_or_held_signal_is_named_and_no_other_alone(fault_free, name, change, by):
    changed = fault_free.with_channels([change(fault_free[name], by)])
    found = diagnose(changed, "midsize-eps", "driver-torque").findings[0]
    assert name in f"{found.cause} {said(found)} {' '.join(found.warnings)}"


@pytest.mark.parametrize(("change", "by"), [(late, 0.1), (held, 0.2)])
def test_a_wrong_gain_is_not_hidden_by_another_wrong_signal(stiff, change, by):
    changed = stiff.with_channels([change(stiff["motor_angle_mechanical"], by)])
    found = diagnose(changed, "midsize-eps", "driver-torque").findings[0]
    assert found.status.exit_code == 1
    assert "motor_angle_mechanical" in found.cause


def test_a_gain_may_be_that_of_the_two_other_signals(fault_free):
    halves = [
        dataclasses.replace(fault_free[name], values=0.5 * fault_free[name].values)
        for name in ("steering_wheel_angle", "driver_torque")
    ]
    found = diagnose(fault_free.with_channels(halves), "midsize-eps", "driver-torque").findings[0]
    assert found.status.exit_code == 1
    assert "or that of steering_wheel_angle and driver_torque together" in found.cause
