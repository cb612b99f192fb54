"""When a running verdict alarmed, and what that means for a fault that came at a known time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Status
from tierod.monitors.harness.session import StatusChange

ALARMS = (Status.RISING, Status.FAULT)
JUDGEMENTS = (Status.HEALTHY, Status.RISING, Status.SUSPECT, Status.FAULT)
"""What a monitor says where it judges; all else says why it does not."""


class Window(NamedTuple):
    """When a fault acts."""

    start: Annotated[float, "s"]
    end: Annotated[float, "s"]


def during(course: Sequence[StatusChange], time: np.ndarray, statuses: Sequence[Status]) -> np.ndarray:
    """Whether the running verdict was one of the statuses, for each instant."""
    at = np.searchsorted([change.time for change in course], time, side="right") - 1
    wanted = np.array([change.status in statuses for change in course])
    return wanted[np.maximum(at, 0)] & (at >= 0)


def alarms_of(course: Sequence[StatusChange], statuses: Sequence[Status]) -> list[Window]:
    """When the running verdict was one of the statuses without a break."""
    runs: list[Window] = []
    for change, after in itertools.zip_longest(course, course[1:]):
        if change.status not in statuses:
            continue
        end = after.time if after else math.inf
        if runs and runs[-1].end == change.time:
            runs[-1] = Window(runs[-1].start, end)
        else:
            runs.append(Window(change.time, end))
    return runs


def first_after(alarms: Sequence[Window], start: float, end: float) -> float:
    """When the first alarm began within a time; infinite where none did, or one stood already."""
    if any(alarm.start < start <= alarm.end for alarm in alarms):
        return math.inf
    return min((alarm.start for alarm in alarms if start <= alarm.start <= end), default=math.inf)


def outcome(alarms: Sequence[Window], first: float, fault: Window | None, judged: bool) -> str:
    """What became of a drive, see `tierod.experiments.judged.Judged`.

    Args:
        alarms: all of the drive
        first: when the first one began in the fault [s]; infinite where none did
        fault: when it acted; None in a sound drive
        judged: whether the monitor judged at all in the fault, or in a sound drive
    """
    if fault is None:
        return "false alarm" if alarms else "quiet" if judged else "not judged"
    if any(alarm.start < fault.start <= alarm.end for alarm in alarms):
        return "early"
    return "found" if math.isfinite(first) else "missed" if judged else "not judged"


def enabled_until(alarm: float, start: float, time: np.ndarray, clock: np.ndarray) -> float:
    """Enabled time [s] from a start to an alarm; infinite where there was none.

    Args:
        alarm, start: instants [s]
        time: instants of the drive [s], shape (n,)
        clock: enabled time before each of them [s]
    """
    if not math.isfinite(alarm):
        return math.inf
    begin, end = np.interp((start, alarm), time, clock)
    return float(end - begin)
