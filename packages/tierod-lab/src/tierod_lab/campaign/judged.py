"""Judgement of one drive by one monitor, and times of its alarms."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.findings import Status
from tierod.monitors.harness.session import StatusChange
from tierod_lab.campaign.definition import labels
from tierod_lab.campaign.figures import Moments

ALARMS = (Status.RISING, Status.FAULT)
JUDGEMENTS = tuple(each for each in Status if each.judged)
"""Statuses of a monitor that judges; all others state the reason why it does not."""


class Window(NamedTuple):
    """Time window in which a fault acts."""

    start: Annotated[float, "s"]
    end: Annotated[float, "s"]


def during(course: Sequence[StatusChange], time: np.ndarray, statuses: Sequence[Status]) -> np.ndarray:
    """Whether the running verdict had one of the statuses, for each instant."""
    at = np.searchsorted([change.time for change in course], time, side="right") - 1
    wanted = np.array([change.status in statuses for change in course])
    return wanted[np.maximum(at, 0)] & (at >= 0)


def alarms_of(course: Sequence[StatusChange], statuses: Sequence[Status]) -> list[Window]:
    """Windows in which the running verdict had one of the statuses without interruption."""
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
    """Start of the first alarm within a window; infinite if there was none, or if an alarm was already active."""
    if any(alarm.start < start <= alarm.end for alarm in alarms):
        return math.inf
    return min((alarm.start for alarm in alarms if start <= alarm.start <= end), default=math.inf)


def outcome(alarms: Sequence[Window], first: float, fault: Window | None, judged: bool) -> str:
    """Outcome of a drive, see `tierod_lab.campaign.judged.Judged`."""
    if fault is None:
        return "false alarm" if alarms else "quiet" if judged else "not judged"
    if any(alarm.start < fault.start <= alarm.end for alarm in alarms):
        return "early"
    return "found" if math.isfinite(first) else "missed" if judged else "not judged"


def enabled_until(alarm: float, start: float, time: np.ndarray, clock: np.ndarray) -> float:
    """Enabled time from a start to an alarm [s]; infinite if there was none."""
    if not math.isfinite(alarm):
        return math.inf
    begin, end = np.interp((start, alarm), time, clock)
    return float(end - begin)


@dataclass(frozen=True)
class Judged:
    """Judgement of one drive by a monitor, from which every figure of a campaign is computed.

    Args:
        status: status of the final finding
        value, deviation: final estimate and its standard deviation, in its unit; NaN if it is withheld
        ratio: final ratio to the baseline [-]; NaN if the monitor has none
        outcome: of a drive with a fault: "found", "missed", "early" (an alarm was active when the fault started) or
            "not judged"; of a fault-free drive: "quiet", "false alarm" or "not judged"
        detection_s, detection_enabled_s: time from the fault's onset to the first alarm; infinite if there was none
        fault_s, fault_enabled_s: the same to the first status "fault"
        false_alarms: number of alarms that started before the fault
        seconds, enabled_s, judged_s: duration of the drive, enabled time, and time in which the monitor judged
        truth_fault_free, truth_faulty: mean true value before and during the fault
        errors_fault_free, errors_faulty: moments of estimate minus true value before the fault and, settled, during it
        area: area under the ROC curve between estimates before and during the fault of this drive
        estimates_fault_free, estimates_faulty: estimates before the fault and settled ones during it, one every few
            seconds
    """

    status: str
    headline: str
    cause: str
    value: float
    deviation: float
    unit: str
    ratio: float
    outcome: str
    detection_s: float
    detection_enabled_s: float
    fault_s: float
    fault_enabled_s: float
    false_alarms: int
    seconds: float
    enabled_s: float
    judged_s: float
    fault_free_s: float
    fault_free_judged_s: float
    truth_fault_free: float
    truth_faulty: float
    errors_fault_free: Moments
    errors_faulty: Moments
    area: float
    estimates_fault_free: tuple[float, ...]
    estimates_faulty: tuple[float, ...]


def plain(judged: Judged) -> dict[str, Any]:
    """The judgement as plain JSON."""
    found: dict[str, Any] = json_value(dataclasses.asdict(judged))
    return found


def json_value(value: object) -> Any:
    """A value as plain JSON: NaN becomes null, infinity the text "inf"."""
    if isinstance(value, Mapping):
        return {str(key): json_value(entry) for key, entry in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [json_value(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else "inf"
    return value


def from_plain(content: Mapping[str, Any]) -> Judged:
    values: dict[str, Any] = {}
    for field in dataclasses.fields(Judged):
        value = content[field.name]
        if field.type == "float":
            value = math.nan if value is None else float(value)
        elif field.type == "Moments":
            mean = value["mean"]
            value = Moments(int(value["count"]), math.nan if mean is None else float(mean), float(value["squares"]))
        elif field.type == "tuple[float, ...]":
            value = tuple(map(float, value))
        values[field.name] = value
    return Judged(**values)


FAULT_FREE = "fault-free"
"""Level of the fault axis for drives without a fault."""

FAULT, SIZE, SEED = "fault", "size", "seed"
"""Axes of every campaign."""


@dataclass(frozen=True)
class Row:
    """Result of one monitor on one drive.

    Args:
        drive: record of the drive: outcome "driven", "diverged" or "failed", reason, seconds, recording, provenance
        judged: its judgement; None if there is none
    """

    place: Mapping[str, str]
    drive: Mapping[str, Any]
    monitor: str
    judged: Judged | None
    reason: str = ""

    @property
    def faulty(self) -> bool:
        """Whether the drive has a fault that actually started."""
        return self.place[FAULT] != FAULT_FREE and any(each["start"] is not None for each in self.drive["windows"])

    @property
    def given(self) -> str:
        """True state: the fault with its magnitude, or `FAULT_FREE`, also if the fault of the drive never started."""
        if self.drive["outcome"] == "driven" and not self.faulty:
            return FAULT_FREE
        return " ".join(part for part in (self.place[FAULT], self.place[SIZE]) if part)


def matching(rows: Iterable[Row], where: Mapping[str, object], monitor: str | None = None) -> list[Row]:
    """The rows at some levels."""
    return [row for row in rows if monitor in (None, row.monitor) and is_at(row.place, where)]


def is_at(place: Mapping[str, str], where: Mapping[str, object]) -> bool:
    return all(place.get(axis) in labels(levels) for axis, levels in where.items())
