"""Recordings of drives at 100 Hz, those of a calibration, and odd ones, which must not cause a false alarm."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.core.statuses import Status
from tierod_lab.ground.courses import AnyCourse, load
from tierod_lab.ground.courses.course import Adhesion, Along
from tierod_lab.ground.courses.roads import Circuit, Halt
from tierod_lab.ground.faults import injected
from tierod_lab.ground.run import run
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.papers.condition.drives import (
    ASKED,
    LONG,
    MEASURED,
    SENSORS,
    SHORT,
    TORQUES,
    Drive,
    calibration_drives,
    course,
    vehicle,
)

RATE = 100.0  # Sampling rate of all channels [Hz]

TRUTHS = {f"truth_{name}": SIGNALS[name].unit for name in SENSORS} | {
    "truth_speed": "m/s",
    "truth_sideslip_angle": "rad",
    "truth_longitudinal_acceleration": "m/s**2",
    "truth_lateral_acceleration": "m/s**2",
    **{f"truth_{name}": "N*m" for name in TORQUES.values()},
    "truth_bank_angle": "rad",
    "truth_grade_angle": "rad",
    "truth_road_friction": "",
    "truth_position_x": "m",
    "truth_position_y": "m",
    "truth_lateral_offset": "m",
}
"""True signals that are kept beside the measured ones -> unit."""

UNITS = {name: SIGNALS[name].unit for name in MEASURED} | TRUTHS  # Channel -> unit, for all channels of a recording


def recorded(drive: Drive) -> Recording:
    """The recording of a drive: `MEASURED` and `TRUTHS` on one time grid of 100 Hz.

    Faults of sensors affect the recording alone: they are injected into that of the drive without them, so that several
    drives share one simulation.
    """
    late = tuple(each for each in drive.injected if each.element in SENSORS)
    base = _driven(replace(drive, injected=tuple(each for each in drive.injected if each.element not in SENSORS)))
    if late:
        base = injected(base, [each.fault for each in late], drive.driven.sensors, drive.seed)
    return replace(base, metadata={**base.metadata, "faults": [asdict(each) for each in drive.injected]})


@lru_cache(maxsize=4)
def _driven(drive: Drive) -> Recording:
    car, sensors = drive.driven
    way = course(drive.course, drive.seconds, drive.seed)
    faults = [each.fault for each in drive.injected]
    return as_recorded(run(car, way, drive.seconds, drive.seed, sensors, faults).recording)


def as_recorded(made: Recording) -> Recording:
    """Reduce a recording of the proving ground to `MEASURED` and `TRUTHS` on one time grid, as `recorded` does."""
    columns = {name: made[name].values.astype(np.float32).astype(float) for name in UNITS}
    time = np.arange(len(columns[MEASURED[0]])) / RATE
    channels = {name: Channel(name, time, values, UNITS[name]) for name, values in columns.items()}
    return Recording(channels, {"source": "tierod virtual test vehicle"})


def fault_free(sensor: str, recording: Recording, sensors: SensorSet) -> np.ndarray:
    """Readings of a sensor without fault and noise, but with its gain and bias, in its unit."""
    return sensors[sensor].gain * recording[f"truth_{sensor}"].values + sensors[sensor].bias


class CalibrationSet(NamedTuple):
    """Fault-free recordings of a vehicle for its calibration."""

    fitted: list[Recording]  # recordings for the parameters
    healthy: list[Recording]  # recordings for limits and thresholds


def calibration_set(number: int, quick: bool, drives: int = 2) -> CalibrationSet:
    """Five fault-free minutes and an hour of a vehicle.

    Args:
        quick: whether 80 s, little more than a calibration requires, and a few drives of ten minutes must do
        drives: number of drives of ten minutes in a short set; with fewer than two, limits cannot be designed
    """
    first, hour = calibration_drives(number)
    first = replace(first, seconds=80.0) if quick else first
    return CalibrationSet([recorded(first)], [recorded(each) for each in (hour[:drives] if quick else hour)])


STEERING = SENSORS[3:]  # Signals of the steering bus
SECONDS = 60.0
NUMBER = 1  # Number of the demonstrator


def _usual(course: str = SHORT, seed: int = 71) -> Recording:
    return recorded(Drive(course, SECONDS, NUMBER, seed))


def _on(course: AnyCourse) -> Recording:
    car, sensors = vehicle(NUMBER)
    return as_recorded(run(car, course, SECONDS, 73, sensors).recording)


def _round(name: str, icy: tuple[float, ...] = (), **changed: object) -> Recording:
    """A drive on a round that is icy from one place to another along it [m], with frictions at left and right."""
    course = load(name)
    assert isinstance(course, Circuit)
    if icy:
        begin, end, left, right = icy
        changed |= {"speed": 9.0, "conditions": (Adhesion(window=Along(begin, end, 1.0), left=left, right=right),)}
    return _on(replace(course, time=SECONDS, **changed))  # type: ignore[arg-type]


def without(recording: Recording, name: str) -> Recording:
    """The recording without a channel."""
    kept = {each: channel for each, channel in recording.channels.items() if each != name}
    return Recording(kept, recording.metadata)


def _changed(
    names: Iterable[str], change: Callable[[np.ndarray, np.ndarray], np.ndarray], long: bool = False
) -> Recording:
    """A usual recording with changed values of some channels, by their times [s] and values."""
    recording = _usual(LONG, 72) if long else _usual()
    channels = {name: recording[name] for name in names}
    changed = {name: replace(each, values=change(each.time, each.values)) for name, each in channels.items()}
    return Recording({**recording.channels, **changed}, recording.metadata)


def _ending(names: Iterable[str], how: str = "silent") -> Recording:
    """A usual recording whose channels end after 20 s: without values, with zeros, or held at the last value."""

    def end(time: np.ndarray, values: np.ndarray) -> np.ndarray:
        last = values[np.searchsorted(time, 20.0) - 1]
        return np.where(time < 20.0, values, {"silent": np.nan, "zero": 0.0, "held": last}[how])

    return _changed(names, end)


def _late(start: float) -> Recording:
    """A usual recording in which the steering bus is 0.3 s late from a time on [s]."""
    return _changed(STEERING, lambda time, values: np.where(time < start, values, np.interp(time - 0.3, time, values)))


def _with_gaps(names: Iterable[str], length: float) -> Recording:
    """A usual recording with gaps [s] every ten seconds."""
    return _changed(names, lambda time, values: np.where(np.mod(time - 5.0, 10.0) < length, np.nan, values), long=True)


def _restarted() -> Recording:
    recording = _usual()
    channels = {}
    for name, each in recording.channels.items():
        kept = each.time >= 31.0
        channels[name] = replace(each, time=each.time[kept] - each.time[kept][0], values=each.values[kept])
    return Recording(channels, recording.metadata)


def _swapped() -> Recording:
    recording = _usual()
    swapped = {
        name: replace(recording[other], name=name) for name, other in zip(SENSORS[:2], SENSORS[1::-1], strict=True)
    }
    return Recording({**recording.channels, **swapped}, recording.metadata)


ODD: Mapping[str, Callable[[], Recording]] = {
    "standstill": partial(_round, SHORT, wait=2.0 * SECONDS),
    "three-point turns with reversing": lambda: _on(load("three-point-turn")),
    "ice on a bend": partial(_round, LONG, (78.0, 110.0, 0.36, 0.36)),
    "ice on one side": partial(_round, LONG, (78.0, 110.0, 0.2, 0.7)),
    "braking harder than ice holds": partial(_round, LONG, (30.0, 76.0, 0.3, 0.3), halts=(Halt(60.0, 2.0),)),
    "driving off harder than ice holds": partial(_round, LONG, (-5.0, 20.0, 0.2, 0.2)),
    "restart in mid-drive": _restarted,
    "wheels swapped": _swapped,
    "angle in another gear ratio": lambda: _changed(STEERING[:1], lambda time, values: 1.25 * values),
    "steering bus 0.3 s late": partial(_late, 0.0),
    "gaps of 0.3 s in all signals": partial(_with_gaps, SENSORS, 0.3),
    "gaps of 2 s in the steering's signals": partial(_with_gaps, STEERING, 2.0),
    "steering bus 0.3 s late from 30 s on": partial(_late, 30.0),
    "all six sensors read zero from 20 s on": partial(_ending, SENSORS, "zero"),
    "all six sensors are silent from 20 s on": partial(_ending, SENSORS),
    "all six sensors repeat themselves from 20 s on": partial(_ending, SENSORS, "held"),
    "steering bus is silent from 20 s on": partial(_ending, STEERING),
    "tie rod force is silent from 20 s on": partial(_ending, ("tie_rod_force",)),
    "targets are missing from 20 s on": partial(_ending, tuple(ASKED.values())),
    **{
        f"without {name.replace('_', ' ')}": lambda name=name: without(_usual(LONG, 72), name)  # type: ignore[misc]
        for name in SENSORS
    },
}
"""Name -> maker of an unusual recording of a fault-free vehicle."""

NOT_HEALTHY: Mapping[str, Status] = dict.fromkeys(
    ("standstill", "wheels swapped", "angle in another gear ratio", *(name for name in ODD if "0.3 s late" in name)),
    Status.NOT_TESTABLE,
) | dict.fromkeys((name for name in ODD if name.endswith("from 20 s on")), Status.NOT_AVAILABLE)
"""Name of an unusual recording -> expected verdict; all others end with healthy."""


def odd_drives() -> dict[str, Recording]:
    """All unusual recordings, by name."""
    return {name: made() for name, made in ODD.items()}
