"""A verdict rests on what was judged, and says until when that was."""

from __future__ import annotations

import dataclasses
import itertools
import re

import numpy as np
import pytest

from driven import drive
from exact_vehicle import diagnose
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.monitors.registry import MONITORS
from tierod.monitors.run import Run
from tierod.monitors.runner import find
from tierod.vehicles import load
from tierod_lab.ground import FrictionCourse

REQUIRED = MONITORS["friction"].required


@pytest.fixture(scope="module")
def rising() -> Recording:
    return drive(minutes=13.0, friction=FrictionCourse.step(4.0, 8.0, at=390.0), seed=1)


def held(recording: Recording, name: str, start: float, stop: float = np.inf) -> Recording:
    """The recording with one signal frozen over a time."""
    channel = recording[name]
    values, at = channel.values.copy(), (channel.time >= start) & (channel.time < stop)
    values[at] = values[np.flatnonzero(at)[0]]
    return recording.with_channels([dataclasses.replace(channel, values=values)])


@pytest.mark.parametrize("name", REQUIRED)
def test_a_signal_that_freezes_before_a_fault_leaves_it_unjudged_and_is_named(rising, name):
    finding = diagnose(held(rising, name, 260.0), "midsize-eps").findings[0]
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert re.match(f"{name} is stuck from 2(59.9|60.0) s on, so nothing was judged after that", finding.cause)
    assert any(warning.startswith(f"{name} is stuck at") for warning in finding.warnings)
    # Rate and angle contradict each other once the wheel turns; the others are known after a second.
    slowest = 280.0 if name == "steering_wheel_angle" else 261.1
    assert 260.9 < finding.evidence["signals_complete_until_s"] < slowest


def test_a_signal_that_is_lost_before_a_fault_leaves_it_unjudged_and_is_named(rising):
    lost = rising.with_channels([rising["yaw_rate"].sliced(0.0, 260.0)])
    finding = diagnose(lost, "midsize-eps").findings[0]
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert finding.cause.startswith("yaw_rate is missing from 26")


def test_a_signal_that_comes_back_is_judged_again(rising):
    finding = diagnose(held(rising, "yaw_rate", 200.0, 300.0), "midsize-eps").findings[0]
    assert finding.status is Status.FAULT
    assert any("from 200.0 s to 300.0 s" in warning for warning in finding.warnings)
    assert "repair or check yaw_rate: it was stuck from 200.0 s to 300.0 s" in finding.action


def test_a_healthy_verdict_beside_a_signal_that_froze_asks_to_check_it():
    sound = drive(minutes=8.0, seed=3)
    assert "stuck" not in diagnose(sound, "midsize-eps").findings[0].action
    finding = diagnose(held(sound, "driver_torque", 120.0, 140.0), "midsize-eps").findings[0]
    assert finding.status is Status.HEALTHY
    assert re.match(r"repair or check driver_torque: it was stuck from 1(19.9|20.0) s to 140.0 s", finding.action)


def test_what_is_stuck_does_not_depend_on_how_the_recording_is_cut(rising):
    frozen = held(held(rising, "yaw_rate", 200.0, 300.0), "driver_torque", 500.0)
    whole = diagnose(frozen, "midsize-eps").findings[0]
    monitor, variant = find("friction")
    run = Run(monitor, variant, load("midsize-eps"))
    cuts = [0.0, 200.43, 200.87, 300.02, 500.5, 500.99, 800.0]
    for start, stop in itertools.pairwise(cuts):
        run.add(frozen.slice(start, stop))
    assert run.finish().findings[0] == whole
