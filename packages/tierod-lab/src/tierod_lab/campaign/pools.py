"""Figures of groups of judged drives: detection times, missed faults, false alarms, and errors of the estimates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.claims import Goal
from tierod_lab.campaign.figures import Moments, area_under_curve, pooled, quantile, rate_bound, share_bound
from tierod_lab.campaign.judging import Judged, Row, matching
from tierod_lab.campaign.matrix import FAULT, FAULT_FREE, SIZE, labels

HOUR = 3600.0


class Pool(NamedTuple):
    """Figures of a group of rows; NaN without data, infinite for an event that never occurred."""

    drives: Annotated[int, ""]
    diverged: Annotated[int, ""]
    failed: Annotated[int, ""]  # drives that could not be simulated or judged at all
    # drives in which the monitor judged nothing of the fault, or of the fault-free drive
    not_judged: Annotated[int, ""]
    fault_free: Annotated[int, ""]  # fault_free, faulty: judged drives without and with a fault
    faulty: Annotated[int, ""]
    found: Annotated[int, ""]  # faults that raised an alarm
    missed: Annotated[int, ""]  # faults that were judged without an alarm
    early: Annotated[int, ""]  # faults that started during an alarm
    missed_share: Annotated[float, ""]  # share of faults missed or not judged among all but the early ones
    missed_share_bound: Annotated[float, ""]  # its 95 % upper bound
    # detection_median_s, detection_p95_s, detection_worst_s: time from the fault to the first alarm; infinite for a
    # fault that was missed or not judged; without the early ones
    detection_median_s: Annotated[float, "s"]
    detection_p95_s: Annotated[float, "s"]
    detection_worst_s: Annotated[float, "s"]
    # detection_enabled_median_s, detection_enabled_p95_s, detection_enabled_worst_s: the same in enabled time
    detection_enabled_median_s: Annotated[float, "s"]
    detection_enabled_p95_s: Annotated[float, "s"]
    detection_enabled_worst_s: Annotated[float, "s"]
    # fault_median_s, fault_p95_s, fault_worst_s: time from the fault to the status "fault"
    fault_median_s: Annotated[float, "s"]
    fault_p95_s: Annotated[float, "s"]
    fault_worst_s: Annotated[float, "s"]
    false_alarms: Annotated[int, ""]  # alarms that started before any fault
    fault_free_hours: Annotated[float, "h"]  # driving time before any fault
    fault_free_judged_hours: Annotated[float, "h"]  # judged part of this time
    false_alarm_rate: Annotated[float, "1/h"]
    false_alarm_bound: Annotated[float, "1/h"]  # its 95 % upper bound
    # bias, deviation: mean and standard deviation of the errors of all settled estimates
    bias: Annotated[float, "unit of the estimate"]
    deviation: Annotated[float, "unit of the estimate"]
    bias_fault_free: Annotated[float, "unit of the estimate"]
    deviation_fault_free: Annotated[float, "unit of the estimate"]
    bias_faulty: Annotated[float, "unit of the estimate"]  # bias_faulty, deviation_faulty: the same during the fault
    deviation_faulty: Annotated[float, "unit of the estimate"]
    largest_bias: Annotated[float, "unit of the estimate"]  # largest magnitude of the mean error of one drive
    area: Annotated[float, ""]  # area under the ROC curve between the final estimates of fault-free and faulty drives
    # smallest area under the ROC curve between the estimates of one drive before and during its fault
    smallest_area: Annotated[float, ""]
    enabled_share: Annotated[float, ""]  # enabled_share, judged_share: shares of the driving time
    judged_share: Annotated[float, ""]


def pool(rows: Sequence[Row], fault_free: Sequence[Row] | None = None) -> Pool:
    """The figures of a group of rows of one monitor."""
    judged = [row.judged for row in rows if row.judged is not None]
    faulty = [row.judged for row in rows if row.judged is not None and row.faulty]
    quiet = [
        row.judged for row in (rows if fault_free is None else fault_free) if row.judged is not None and not row.faulty
    ]
    counted = [each for each in faulty if each.outcome != "early"]
    unseen = sum(each.outcome != "found" for each in counted)
    seconds = sum(each.seconds for each in judged)
    return Pool(
        drives=len(rows),
        diverged=sum(row.drive["outcome"] == "diverged" for row in rows),
        failed=sum(row.judged is None and row.drive["outcome"] != "diverged" for row in rows),
        not_judged=sum(each.outcome == "not judged" for each in judged),
        fault_free=len(judged) - len(faulty),
        faulty=len(faulty),
        found=sum(each.outcome == "found" for each in faulty),
        missed=sum(each.outcome == "missed" for each in faulty),
        early=len(faulty) - len(counted),
        missed_share=unseen / len(counted) if counted else math.nan,
        missed_share_bound=share_bound(unseen, len(counted)) if counted else math.nan,
        **_times("detection", [each.detection_s for each in counted]),
        **_times("detection_enabled", [each.detection_enabled_s for each in counted]),
        **_times("fault", [each.fault_s for each in counted]),
        **_false_alarms(judged),
        **_errors(judged),
        area=area_under_curve([each.value for each in quiet], [each.value for each in faulty]),
        smallest_area=min((each.area for each in faulty if not math.isnan(each.area)), default=math.nan),
        enabled_share=sum(each.enabled_s for each in judged) / seconds if seconds else math.nan,
        judged_share=sum(each.judged_s for each in judged) / seconds if seconds else math.nan,
    )


def _false_alarms(judged: Sequence[Judged]) -> Any:
    alarms, hours = sum(each.false_alarms for each in judged), sum(each.fault_free_judged_s for each in judged) / HOUR
    return {
        "false_alarms": alarms,
        "fault_free_hours": sum(each.fault_free_s for each in judged) / HOUR,
        "fault_free_judged_hours": hours,
        "false_alarm_rate": alarms / hours if hours > 0.0 else math.nan,
        "false_alarm_bound": rate_bound(alarms, hours) if hours > 0.0 else math.nan,
    }


def _errors(judged: Sequence[Judged]) -> Any:
    before = pooled(each.errors_fault_free for each in judged)
    within = pooled(each.errors_faulty for each in judged)
    named = {"": pooled((before, within)), "_fault_free": before, "_faulty": within}
    drives = [pooled((each.errors_fault_free, each.errors_faulty)) for each in judged]
    found = {f"bias{part}": errors.mean for part, errors in named.items()}
    found |= {f"deviation{part}": errors.deviation for part, errors in named.items()}
    return found | {"largest_bias": max((abs(each.mean) for each in drives if each.count), default=math.nan)}


def _times(name: str, times: list[float]) -> Any:
    return {
        f"{name}_median_s": quantile(times, 0.5),
        f"{name}_p95_s": quantile(times, 0.95),
        f"{name}_worst_s": quantile(times, 1.0),
    }


def confusion(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """True state -> status -> number of drives, in the order of the rows; failed drives have "no verdict"."""
    found: dict[str, dict[str, int]] = {}
    for row in rows:
        status = row.judged.status if row.judged else "no verdict"
        counts = found.setdefault(row.given, {})
        counts[status] = counts.get(status, 0) + 1
    return found


class Box(NamedTuple):
    """Distribution of the estimates of one state: quantiles at 5, 25, 50, 75 and 95 per cent."""

    state: str
    truth: float
    estimates: int
    low: float
    lower: float
    median: float
    upper: float
    high: float
    bias: float
    deviation: float


def boxes(rows: Sequence[Row]) -> list[Box]:
    """Distribution of the estimates by state: fault-free (also before faults), then every fault with its magnitude."""
    parts: dict[str, list[tuple[float, Moments, tuple[float, ...]]]] = {}
    for row in rows:
        each = row.judged
        if each is None:
            continue
        parts.setdefault(FAULT_FREE, []).append(
            (each.truth_fault_free, each.errors_fault_free, each.estimates_fault_free)
        )
        if row.faulty:
            parts.setdefault(row.given, []).append((each.truth_faulty, each.errors_faulty, each.estimates_faulty))
    return [box for state, found in parts.items() if (box := _box(state, found)) is not None]


def _box(state: str, found: list[tuple[float, Moments, tuple[float, ...]]]) -> Box | None:
    values = np.array([value for _, _, estimates in found for value in estimates])
    if not len(values):
        return None
    errors = pooled(each for _, each, _ in found)
    truths = [truth for truth, _, _ in found if not math.isnan(truth)]
    truth = float(np.mean(truths)) if truths else math.nan
    low, lower, median, upper, high = map(float, np.quantile(values, (0.05, 0.25, 0.5, 0.75, 0.95)))
    return Box(state, truth, len(values), low, lower, median, upper, high, errors.mean, errors.deviation)


@dataclass(frozen=True)
class Gate:
    """A limit on a figure."""

    figure: str
    goal: Goal
    where: Mapping[str, object]
    monitor: str

    @property
    def name(self) -> str:
        place = ", ".join(f"{axis} {' or '.join(labels(levels))}" for axis, levels in self.where.items())
        return f"{self.figure}{f' ({place})' if place else ''}"


@dataclass(frozen=True)
class Passed:
    """Result of a gate."""

    gate: Gate
    measured: float  # value of the figure; NaN if there is none
    met: bool | None  # whether the goal is met; None if that cannot be judged
    note: str  # reason why not, or number of drives


def pass_through(gate: Gate, rows: Sequence[Row]) -> Passed:
    """Compare the figure of a gate with its goal; with failed drives a gate can be missed, but not met."""
    figures = pool_at(rows, gate.where, gate.monitor)
    measured = float(getattr(figures, gate.figure))
    lost = figures.failed + figures.diverged
    if math.isnan(measured):
        return Passed(gate, measured, None, "there are no data for this figure")
    if not gate.goal.holds(measured):
        return Passed(gate, measured, False, f"{figures.drives} drives")
    if lost:
        return Passed(gate, measured, None, f"{lost} of {figures.drives} drives failed, so it cannot be judged as met")
    return Passed(gate, measured, True, f"{figures.drives} drives")


def pool_at(rows: Sequence[Row], where: Mapping[str, object], monitor: str) -> Pool:
    """Figures of the rows at some levels; faulty drives are compared with the fault-free ones of the other levels."""
    others = {axis: level for axis, level in where.items() if axis not in (FAULT, SIZE)}
    fault_free = matching(rows, {**others, FAULT: FAULT_FREE}, monitor)
    return pool(matching(rows, where, monitor), fault_free)
