"""Alarm times of a running verdict, and the judgement of one drive by one monitor."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.findings import Status
from tierod.experiments.figures import Moments
from tierod.monitors.harness.session import StatusChange

ALARMS = (Status.RISING, Status.FAULT)
JUDGEMENTS = (Status.HEALTHY, Status.RISING, Status.SUSPECT, Status.FAULT)
"""Statuses of a monitor that judges; all others give the reason why it does not."""


class Window(NamedTuple):
    """Time in which a fault acts."""

    start: Annotated[float, "s"]
    end: Annotated[float, "s"]


def during(course: Sequence[StatusChange], time: np.ndarray, statuses: Sequence[Status]) -> np.ndarray:
    """Whether the running verdict was one of the statuses, for each instant."""
    at = np.searchsorted([change.time for change in course], time, side="right") - 1
    wanted = np.array([change.status in statuses for change in course])
    return wanted[np.maximum(at, 0)] & (at >= 0)


def alarms_of(course: Sequence[StatusChange], statuses: Sequence[Status]) -> list[Window]:
    """Times in which the running verdict was one of the statuses without a break."""
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
    """Time at which the first alarm began within a time; infinite where none did, or one stood already."""
    if any(alarm.start < start <= alarm.end for alarm in alarms):
        return math.inf
    return min((alarm.start for alarm in alarms if start <= alarm.start <= end), default=math.inf)


def outcome(alarms: Sequence[Window], first: float, fault: Window | None, judged: bool) -> str:
    """Outcome of a drive, see `tierod.experiments.judged.Judged`.

    Args:
        alarms: all of the drive
        first: when the first one began in the fault [s]; infinite where none did
        fault: when it acted; None in a fault-free drive
        judged: whether the monitor judged at all in the fault, or in a fault-free drive
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


@dataclass(frozen=True)
class Judged:
    """Judgement of one drive by a monitor; every figure of a campaign is made from these.

    Args:
        status: of the final finding
        headline, cause: of the final finding
        value, deviation: of the final estimate, in its unit; NaN where it is withheld
        unit: of the estimate
        ratio: to the baseline at the end [-], NaN where the monitor has none
        outcome: of a drive with a fault: "found", "missed", "early" (an alarm stood already when the fault came) or
            "not judged"; of a fault-free one: "quiet", "false alarm" or "not judged"
        detection_s, detection_enabled_s: from the fault's start to the first alarm; infinite where there was none
        fault_s, fault_enabled_s: the same to the first verdict "fault"
        false_alarms: alarms that began while no fault had acted yet
        seconds, enabled_s, judged_s: of the drive, in which the monitor learnt, and in which it judged
        fault_free_s, fault_free_judged_s: before the fault; judged of these
        truth_fault_free, truth_faulty: mean of the truth in both phases
        errors_fault_free, errors_faulty: estimate less truth in both phases, settled; see `Phase`
        area: under the ROC curve between estimates before and in the fault, of this drive
        estimates_fault_free, estimates_faulty: settled estimates, one every few seconds
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
    """The judgement as JSON holds it."""
    found: dict[str, Any] = json_value(dataclasses.asdict(judged))
    return found


def json_value(value: object) -> Any:
    """A value as JSON holds it: NaN is null, infinity the text "inf"."""
    if isinstance(value, Mapping):
        return {str(key): json_value(entry) for key, entry in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [json_value(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else "inf"
    return value


def from_plain(content: Mapping[str, Any]) -> Judged:
    """Judgement read back from what `plain` wrote.

    Raises:
        KeyError, TypeError, ValueError: something else
    """
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
