"""Which signal of a drive is late, of another scale or clipped, by its name; and what that does to a verdict."""

from __future__ import annotations

import dataclasses
import itertools
import re
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest

from driven import drive
from exact_vehicle import diagnose
from tierod.core.facts import Fact
from tierod.core.findings import Status
from tierod.core.recording import Recording
from tierod.monitors.defects import InputDefects
from tierod.monitors.registry import MONITORS
from tierod.monitors.run import Run
from tierod.monitors.runner import find
from tierod.vehicles import load
from tierod_lab.ground import FrictionCourse

SIGNALS = MONITORS["friction"].required


@pytest.fixture(scope="module")
def healthy() -> Recording:
    return drive(minutes=8.0, seed=3)


def altered(recording: Recording, name: str, change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Recording:
    channel = recording[name]
    return recording.with_channels([dataclasses.replace(channel, values=change(channel.time, channel.values))])


def late(seconds: float) -> Callable:
    return lambda time, values: np.interp(time - seconds, time, values)


def times(factor: float) -> Callable:
    return lambda _time, values: factor * values


def clipped(_time: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.clip(values, *np.quantile(values, [0.1, 0.9]))


def defects_of(recording: Recording, names: tuple[str, ...]) -> tuple[Fact, ...]:
    defects = InputDefects(names)
    defects.add(recording, *recording.span)
    return defects.found()


def sentences(recording: Recording) -> list[str]:
    return [each.cause for each in defects_of(recording, SIGNALS)]


@pytest.mark.parametrize(
    "name",
    [
        "steering_wheel_angle",
        "steering_wheel_rate",
        "driver_torque",
        "motor_torque",
        "yaw_rate",
        "lateral_acceleration",
    ],
)
def test_a_late_signal_is_named_with_its_delay(healthy, name):
    (sentence,) = sentences(altered(healthy, name, late(0.5)))
    assert sentence.startswith(f"{name} is late relative to ")
    delay, deviation = (float(each) for each in sentence.split(" by ")[1].removesuffix(" s").split(" ± "))
    assert abs(delay - 0.5) < 2.0 * deviation < 0.2


@pytest.mark.parametrize("name", ["steering_wheel_rate", "steering_wheel_angle", "yaw_rate", "lateral_acceleration"])
@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_wrong_scale_is_named_with_those_that_it_may_be(healthy, name, factor):
    (sentence,) = sentences(altered(healthy, name, times(factor)))
    assert "has a wrong scale" in sentence
    assert name in sentence.split(" has ")[0]
    ratio = float(sentence.split(" is ")[1].split(" times ")[0])
    # The second quantity over the first; the sentence names that of the second first.
    assert ratio == pytest.approx(factor if sentence.startswith(name) else 1.0 / factor, rel=0.2)


@pytest.mark.parametrize("name", ["driver_torque", "motor_torque", "yaw_rate", "lateral_acceleration"])
def test_a_clipped_signal_is_named(healthy, name):
    found = sentences(altered(healthy, name, clipped))
    ends = {said.split(" its ")[1].split()[0] for said in found if said.startswith(f"{name} is clipped at its ")}
    assert ends
    assert ends <= {"upper", "lower"}


def test_a_healthy_drive_has_none(healthy):
    assert sentences(healthy) == []


@pytest.mark.parametrize(
    ("name", "change", "beginning"),
    [
        ("driver_torque", times(2.0), "driver_torque has "),
        ("driver_torque", times(0.5), "driver_torque has "),
        ("motor_torque", times(2.0), "motor_torque has "),
        ("motor_torque", times(0.5), "motor_torque has "),
        ("motor_torque", clipped, "motor_torque is clipped at "),
        ("lateral_acceleration", late(0.5), "lateral_acceleration is late relative to yaw_rate"),
        ("motor_torque", late(0.5), "motor_torque is late relative to driver_torque"),
    ],
)
@pytest.mark.parametrize("friction", [None, 8.0])
def test_friction_is_suspect_and_the_right_signal_comes_first(healthy, name, change, beginning, friction):
    recording = drive(minutes=8.0, seed=3, friction=friction) if friction else healthy
    finding = diagnose(altered(recording, name, change), "midsize-eps").findings[0]
    assert finding.status in (Status.SUSPECT, Status.NOT_IDENTIFIABLE)
    assert finding.cause.startswith(beginning)


def test_what_is_found_does_not_depend_on_how_the_recording_is_cut(healthy):
    changed = altered(altered(healthy, "lateral_acceleration", late(0.5)), "driver_torque", times(2.0))
    whole = diagnose(changed, "midsize-eps").findings[0]
    run = Run(*find("friction"), load("midsize-eps"))
    for start, stop in itertools.pairwise([0.0, 37.43, 120.0, 120.5, 333.331, 500.0]):
        run.add(changed.slice(start, stop))
    assert run.finish().findings[0] == whole


@pytest.mark.parametrize(
    ("start", "stop", "when"),
    [(-1.0, 5.0, "until 5.0 s"), (20.0, 30.0, "from 20.0 s to 30.0 s"), (50.0, 99.0, "from 5")],
)
def test_a_signal_that_pauses_is_named_with_its_times(healthy, start, stop, when):
    def gone(time: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.where((time >= start) & (time < stop), np.nan, values)

    paused = altered(healthy.slice(stop=60.0), "lateral_acceleration", gone)
    finding = diagnose(paused, "midsize-eps").findings[0]
    assert f"lateral_acceleration is missing {when}" in " ".join((finding.cause, *finding.warnings))


def test_a_pause_of_many_hours_takes_no_memory(healthy):
    channels = {
        name: dataclasses.replace(each, time=np.where(each.time > 60.0, each.time + 14400.0, each.time))
        for name, each in healthy.slice(stop=120.0).channels.items()
    }
    paused = Recording(channels)
    defects = InputDefects(tuple(channels))
    tracemalloc.start()
    defects.add(paused, paused.span[0], paused.span[1])
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert defects.found() == ()
    assert most < 12e6, "the grid of the pause takes 6 MB of every signal"


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
