"""Preparation of fault-free drives for a calibration: on one grid, without long gaps, and each only once."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.monitors.condition.calibration.grid import RATE, aligned, moving, sampled, wheel_of
from tierod.monitors.condition.recording_checks.coverage import TargetPace
from tierod.monitors.condition.signals import WHEELS

GAP = 5.0
"""Gap in the wheel speeds from which the rest counts as another drive [s]."""


class HealthyDrive(NamedTuple):
    """Fault-free drive without long gaps.

    Args:
        name: name of the recording that it comes from
        recording: signals of `ConditionSample` on one grid
        driven: time for which the vehicle moves [s]
    """

    name: str
    recording: Recording
    driven: Annotated[float, "s"]


def healthy_drives(recordings: Mapping[str, Recording]) -> list[HealthyDrive]:
    """Split recordings into drives, in their order.

    Args:
        recordings: recordings by name

    Raises:
        InputError: a recording lacks the speeds of the rear wheels, or their rate or that of the actuator targets is
            too low; or two recordings hold the same drive
    """
    drives: list[HealthyDrive] = []
    seen: dict[bytes, str] = {}
    for name, recording in recordings.items():
        wheel = wheel_of(name, recording)
        content = _digest(recording)
        if content in seen:
            raise InputError(f"{seen[content]} and {name} hold the same drive; it counts once: leave one out")
        seen[content] = name
        gridded = [_on_grid(name, piece) for piece in _unbroken(recording[wheel].time, recording)]
        _refuse_slow_targets(name, gridded)
        drives += gridded
    return drives


def _refuse_slow_targets(name: str, drives: Sequence[HealthyDrive]) -> None:
    pace = TargetPace(RATE)
    for drive in drives:
        pace.add(aligned(drive.recording))
    if problems := pace.problems():
        raise InputError(f"{name}: {problems[0].cause}, in calibration as in the monitor; {problems[0].action}")


def parted(
    drives: Sequence[HealthyDrive], seconds: float
) -> tuple[list[HealthyDrive], list[HealthyDrive], Annotated[float, "s"]]:
    """Split drives after a given time of driving.

    Args:
        drives: drives in their order
        seconds: time of driving of the first part, standstill not counted [s]

    Returns:
        drives of the first part, drives of the rest, and the time of driving of the first part [s]
    """
    first: list[HealthyDrive] = []
    rest: list[HealthyDrive] = []
    driven = 0.0
    for drive in drives:
        left = seconds - driven
        if left <= 0.0:
            rest.append(drive)
        elif drive.driven <= left:
            first.append(drive)
            driven += drive.driven
        else:
            # Half a step of the grid keeps rounding errors from moving the cut by a whole step.
            driven_until = np.cumsum(_moving(drive.recording)) / RATE
            place = int(np.searchsorted(driven_until, left - 0.5 / RATE))
            cut = float(drive.recording[wheel_of(drive.name, drive.recording)].time[place]) + 0.5 / RATE
            first.append(HealthyDrive(drive.name, drive.recording.slice(stop=cut), left))
            rest.append(HealthyDrive(drive.name, drive.recording.slice(cut), drive.driven - left))
            driven = seconds
    return first, rest, driven


def _digest(recording: Recording) -> bytes:
    """Fingerprint of the rear wheel speeds."""
    return hashlib.sha256(b"".join(recording[each].values.tobytes() for each in WHEELS if each in recording)).digest()


def _unbroken(time: np.ndarray, recording: Recording) -> Iterator[Recording]:
    """Pieces of a recording between gaps that are too long for a filter to continue."""
    after = np.flatnonzero(np.diff(time) > GAP) + 1
    bounds = [0, *after.tolist(), len(time)]
    for begin, end in pairwise(bounds):
        if time[end - 1] - time[begin] > GAP:
            yield recording.slice(float(time[begin]), float(time[end - 1]) + 0.5 / RATE)


def _on_grid(name: str, recording: Recording) -> HealthyDrive:
    samples = sampled(recording)
    columns = zip(samples.names, samples.values.T, strict=True)
    channels = {
        each: Channel(each, samples.time, np.ascontiguousarray(values), recording[each].unit)
        for each, values in columns
        if each in recording
    }
    gridded = Recording(channels, recording.metadata)
    return HealthyDrive(name, gridded, float(np.count_nonzero(_moving(gridded))) / RATE)


def _moving(recording: Recording) -> np.ndarray:
    """Whether the vehicle moves, for every step of the grid."""
    there = [recording[each].values for each in WHEELS if each in recording]
    return moving(np.column_stack(there))
