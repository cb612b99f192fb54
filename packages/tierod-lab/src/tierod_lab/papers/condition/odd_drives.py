"""Recordings of fault-free vehicles with unusual driving, wiring or logging, which must not cause a false alarm."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.core.statuses import Status
from tierod_lab.ground.courses import AnyCourse, load
from tierod_lab.ground.courses.course import Adhesion, Along
from tierod_lab.ground.courses.roads import Circuit, Halt
from tierod_lab.ground.run import run
from tierod_lab.papers.condition.drives import SENSORS, TARGETS, Drive
from tierod_lab.papers.condition.recorded import as_recorded, recorded
from tierod_lab.papers.condition.vehicles import LONG, SHORT, vehicle

STEERING = ("steering_wheel_angle", "steering_shaft_torque", "tie_rod_force")  # Signals of the steering bus
SECONDS = 60.0
HALT = 60.0  # Position of the halt on ice along the round [m]


def odd_drives(number: int = 1) -> dict[str, Recording]:
    """Unusual recordings of a fault-free vehicle, by name."""
    usual = recorded(Drive(SHORT, SECONDS, number, 71))
    long = recorded(Drive(LONG, SECONDS, number, 72))
    found = {
        "standstill": _on(number, replace(_circuit(SHORT), time=SECONDS, wait=2.0 * SECONDS)),
        "three-point turns with reversing": _on(number, load("three-point-turn")),
        **{name: on_ice(number, name) for name in SLIPPERY},
        "restart in mid-drive": sliced(usual, 31.0),
        "wheels swapped": _renamed(usual, dict(zip(SENSORS[:2], reversed(SENSORS[:2]), strict=True))),
        "angle in another gear ratio": scaled(usual, "steering_wheel_angle", 1.25),
        "steering bus 0.3 s late": late(usual, STEERING, 0.3),
        "gaps of 0.3 s in all signals": with_gaps(long, SENSORS, 0.3),
        "gaps of 2 s in the steering's signals": with_gaps(long, STEERING, 2.0),
        "steering bus 0.3 s late from 30 s on": late(usual, STEERING, 0.3, 30.0),
        "all six sensors read zero from 20 s on": ending(usual, SENSORS, 20.0, "zero"),
        "all six sensors are silent from 20 s on": ending(usual, SENSORS, 20.0),
        "all six sensors repeat themselves from 20 s on": ending(usual, SENSORS, 20.0, "held"),
        "steering bus is silent from 20 s on": ending(usual, STEERING, 20.0),
        "tie rod force is silent from 20 s on": ending(usual, ("tie_rod_force",), 20.0),
        "targets are missing from 20 s on": ending(usual, tuple(TARGETS.values()), 20.0),
    }
    return found | {f"without {name.replace('_', ' ')}": without(long, name) for name in SENSORS}


NOT_HEALTHY: Mapping[str, Status] = {
    "standstill": Status.NOT_TESTABLE,
    "wheels swapped": Status.NOT_TESTABLE,
    "angle in another gear ratio": Status.NOT_TESTABLE,
    "steering bus 0.3 s late": Status.NOT_TESTABLE,
    "steering bus 0.3 s late from 30 s on": Status.NOT_TESTABLE,
    "all six sensors read zero from 20 s on": Status.NOT_AVAILABLE,
    "all six sensors are silent from 20 s on": Status.NOT_AVAILABLE,
    "all six sensors repeat themselves from 20 s on": Status.NOT_AVAILABLE,
    "steering bus is silent from 20 s on": Status.NOT_AVAILABLE,
    "tie rod force is silent from 20 s on": Status.NOT_AVAILABLE,
    "targets are missing from 20 s on": Status.NOT_AVAILABLE,
}
"""Name of an unusual recording -> expected verdict; all others end with healthy."""


def on_ice(number: int, name: str, seconds: float = SECONDS) -> Recording:
    """A fault-free drive on a slippery road.

    Args:
        name: name in `SLIPPERY`
        seconds: duration [s]
    """
    return _on(number, SLIPPERY[name](), seconds)


def _on(number: int, course: AnyCourse, seconds: float = SECONDS) -> Recording:
    car, sensors = vehicle(number)
    return as_recorded(run(car, course, seconds, 73, sensors).recording)


def _braking_on_ice() -> AnyCourse:
    ice = Adhesion(window=Along(HALT - 30.0, HALT + 16.0, 1.0), left=0.3, right=0.3)
    return replace(_circuit(LONG), time=SECONDS, speed=9.0, halts=(Halt(HALT, 2.0),), conditions=(ice,))


def _starting_on_ice() -> AnyCourse:
    ice = Adhesion(window=Along(-5.0, 20.0, 1.0), left=0.2, right=0.2)
    return replace(_circuit(LONG), time=SECONDS, speed=9.0, conditions=(ice,))


def _circuit(name: str) -> Circuit:
    course = load(name)
    assert isinstance(course, Circuit)
    return course


def _icy(left: float, right: float) -> AnyCourse:
    ice = Adhesion(window=Along(78.0, 110.0, 1.0), left=left, right=right)
    return replace(_circuit(LONG), time=SECONDS, speed=9.0, conditions=(ice,))


SLIPPERY: Mapping[str, Callable[[], AnyCourse]] = {
    "ice on a bend": partial(_icy, 0.36, 0.36),
    "ice on one side": partial(_icy, 0.2, 0.7),
    "braking harder than ice holds": _braking_on_ice,
    "driving off harder than ice holds": _starting_on_ice,
}
"""Name -> maker of a course that is slippery in places."""


def sliced(recording: Recording, start: float) -> Recording:
    """The part of a recording after a time [s], with its clock reset to zero."""
    channels = {}
    for name, each in recording.channels.items():
        kept = each.time >= start
        channels[name] = replace(each, time=each.time[kept] - each.time[kept][0], values=each.values[kept])
    return Recording(channels, recording.metadata)


def without(recording: Recording, name: str) -> Recording:
    """The recording without a channel."""
    return Recording(
        {each: channel for each, channel in recording.channels.items() if each != name}, recording.metadata
    )


def scaled(recording: Recording, name: str, factor: float) -> Recording:
    """A recording with one channel multiplied by a factor."""
    return _changed(recording, (name,), lambda time, values: factor * values)


def late(recording: Recording, names: Iterable[str], delay: float, start: float = 0.0) -> Recording:
    """A recording in which some channels are delayed [s] from a start on [s]."""
    return _changed(
        recording,
        names,
        lambda time, values: np.where(time < start, values, np.interp(time - delay, time, values)),
    )


def ending(recording: Recording, names: Iterable[str], start: float, how: str = "silent") -> Recording:
    """A recording in which some channels end.

    Args:
        start: time at which they end [s]
        how: "silent" without values, "zero", or "held" at the last value
    """

    def end(time: np.ndarray, values: np.ndarray) -> np.ndarray:
        last = values[np.searchsorted(time, start) - 1]
        return np.where(time < start, values, {"silent": np.nan, "zero": 0.0, "held": last}[how])

    return _changed(recording, names, end)


def with_gaps(recording: Recording, names: Iterable[str], length: float, every: float = 10.0) -> Recording:
    """A recording in which some channels have periodic gaps.

    Args:
        length: duration of a gap [s]
        every: period of the gaps [s]; the first one begins after half a period
    """

    def gap(time: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.where(np.mod(time - 0.5 * every, every) < length, np.nan, values)

    return _changed(recording, names, gap)


def _changed(
    recording: Recording, names: Iterable[str], change: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> Recording:
    changed = {name: recording[name] for name in names}
    channels: dict[str, Channel] = {
        name: replace(each, values=change(each.time, each.values)) for name, each in changed.items()
    }
    return Recording({**recording.channels, **channels}, recording.metadata)


def _renamed(recording: Recording, names: Mapping[str, str]) -> Recording:
    channels = {name: replace(recording[other], name=name) for name, other in names.items()}
    return Recording({**recording.channels, **channels}, recording.metadata)
