"""Judgement of one monitor on one virtual drive against the true values: alarms, estimation errors, judged time."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.findings import Finding
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.monitors.baseline import Baseline
from tierod.monitors.diagnose import OverTime
from tierod.monitors.run import Run
from tierod.monitors.session import Monitor, StatusChange, Variant
from tierod.vehicles import Vehicle
from tierod_lab.campaign.figures import Moments, area_under_curve
from tierod_lab.campaign.matrix import FAULT, FAULT_FREE, SIZE, is_at

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
    """Outcome of a drive, see `tierod_lab.campaign.judging.Judged`."""
    if fault is None:
        return "false alarm" if alarms else "quiet" if judged else "not judged"
    if any(alarm.start < fault.start <= alarm.end for alarm in alarms):
        return "early"
    return "found" if math.isfinite(first) else "missed" if judged else "not judged"


@dataclass(frozen=True)
class Judged:
    """Judgement of one drive by a monitor, from which every figure of a campaign is computed."""

    status: str  # status of the final finding
    headline: str
    cause: str
    value: float  # value, deviation: final estimate and its standard deviation, in its unit; NaN if it is withheld
    deviation: float
    unit: str
    ratio: float  # final ratio to the baseline [-]; NaN if the monitor has none
    # of a drive with a fault: "found", "missed", "early" (an alarm was active when the fault started) or "not judged";
    # of a fault-free drive: "quiet", "false alarm" or "not judged"
    outcome: str
    # detection_s, detection_enabled_s: time from the fault's onset to the first alarm; infinite if there was none
    detection_s: float
    detection_enabled_s: float
    fault_s: float  # fault_s, fault_enabled_s: the same to the first status "fault"
    fault_enabled_s: float
    false_alarms: int  # number of alarms that started before the fault
    # seconds, enabled_s, judged_s: duration of the drive, enabled time, and time in which the monitor judged
    seconds: float
    enabled_s: float
    judged_s: float
    fault_free_s: float
    fault_free_judged_s: float
    truth_fault_free: float  # truth_fault_free, truth_faulty: mean true value before and during the fault
    truth_faulty: float
    # errors_fault_free, errors_faulty: moments of estimate minus true value before the fault and, settled, during it
    errors_fault_free: Moments
    errors_faulty: Moments
    area: float  # area under the ROC curve between estimates before and during the fault of this drive
    # estimates_fault_free, estimates_faulty: estimates before the fault and settled ones during it, one every few
    # seconds
    estimates_fault_free: tuple[float, ...]
    estimates_faulty: tuple[float, ...]


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


@dataclass(frozen=True)
class Row:
    """Result of one monitor on one drive."""

    place: Mapping[str, str]
    # record of the drive: outcome "driven", "diverged" or "failed", reason, seconds, recording, provenance
    drive: Mapping[str, Any]
    monitor: str
    judged: Judged | None  # its judgement; None if there is none
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


TRUTH = "truth_"
DEVIATION = "_standard_deviation"
"""Suffix of standard deviations: a trace X with a trace X_standard_deviation is an estimate of the channel truth_X."""

SAMPLE_PERIOD = 5.0  # Interval between kept estimates [s]: friction estimates vary over tens of seconds


def judge(
    recording: Recording,
    monitor: tuple[Monitor, Variant],
    belief: Vehicle,
    baseline: Baseline | None,
    fault: Window | None,
    settling: Annotated[float, "s"],
) -> tuple[Judged, Baseline | None]:
    """Run a monitor over a drive and compare it with the true values."""
    kept = OverTime()
    run = Run(*monitor, belief, baseline=baseline, kept=kept.add)
    run.add(recording)
    finding = run.finish().findings[0]
    seen = _Seen(kept.time, {name: kept.values(name) for name in run.session.traces})
    # A monitor that judges the recording as a whole has no status before the end.
    ends = ((seen.time[0], Status.NOT_READY), (seen.time[-1], finding.status))
    course = run.course or tuple(StatusChange(float(time), status) for time, status in ends)
    return _judged(recording, finding, course, seen, fault, settling, 1.0 / run.monitor.rate), run.learnt


class _Seen(NamedTuple):
    """Outputs of a monitor over the drive: time, and traces by name, (n,) each."""

    time: np.ndarray
    traces: dict[str, np.ndarray]


def _judged(
    recording: Recording,
    finding: Finding,
    course: Sequence[StatusChange],
    seen: _Seen,
    fault: Window | None,
    settling: float,
    step: float,
) -> Judged:
    enabled = seen.traces.get("enabled", np.ones(len(seen.time))) > 0.5
    judging = during(course, seen.time, JUDGEMENTS)
    start, end = fault or Window(math.inf, math.inf)
    fault_free, faulty = seen.time < start, (seen.time >= start) & (seen.time < end)
    clock = np.asarray((np.cumsum(enabled) - enabled) * step)
    settled = faulty & (clock >= settling + float(np.interp(start, seen.time, clock, right=math.inf)))
    estimates = _Estimates(recording, seen, judging)
    judged_at_all = bool(judging[faulty if fault else fault_free].any())
    return Judged(
        **_final(finding, seen),
        **_times(course, fault, seen.time, clock, judged_at_all),
        seconds=len(seen.time) * step,
        enabled_s=int(enabled.sum()) * step,
        judged_s=int(judging.sum()) * step,
        fault_free_s=int(fault_free.sum()) * step,
        fault_free_judged_s=int((fault_free & judging).sum()) * step,
        truth_fault_free=estimates.truth_in(fault_free),
        truth_faulty=estimates.truth_in(faulty),
        errors_fault_free=estimates.errors_in(fault_free),
        errors_faulty=estimates.errors_in(settled),
        area=area_under_curve(estimates.values_in(fault_free), estimates.values_in(settled)),
        estimates_fault_free=estimates.kept_in(fault_free, step),
        estimates_faulty=estimates.kept_in(settled, step),
    )


def _final(finding: Finding, seen: _Seen) -> dict[str, Any]:
    known, ratio = finding.estimate, seen.traces.get("ratio_to_baseline")
    return {
        "status": str(finding.status),
        "headline": finding.headline,
        "cause": finding.cause,
        "value": known.value if known else math.nan,
        "deviation": known.standard_deviation if known else math.nan,
        "unit": known.unit if known else "",
        "ratio": float(ratio[-1]) if known and ratio is not None and ratio[-1] > 0.0 else math.nan,
    }


def _times(
    course: Sequence[StatusChange], fault: Window | None, time: np.ndarray, clock: np.ndarray, judged_at_all: bool
) -> dict[str, Any]:
    start, end = fault or Window(math.inf, math.inf)
    alarms = alarms_of(course, ALARMS)
    first, worst = (first_after(alarms_of(course, wanted), start, end) for wanted in (ALARMS, ALARMS[1:]))
    found: dict[str, Any] = {
        "outcome": outcome(alarms, first, fault, judged_at_all),
        "false_alarms": sum(begin < start for begin, _ in alarms),
    }
    for name, instant in (("detection", first), ("fault", worst)):
        found[f"{name}_s"] = instant - start if fault else math.nan
        passed = float(np.diff(np.interp((start, instant), time, clock))[0]) if math.isfinite(instant) else math.inf
        found[f"{name}_enabled_s"] = passed if fault else math.nan
    return found


class _Estimates:
    """Estimates while the monitor judged, and the true values at the same instants."""

    def __init__(self, recording: Recording, seen: _Seen, judging: np.ndarray):
        name = next((n for n in seen.traces if n + DEVIATION in seen.traces), None)
        none = np.full(len(seen.time), np.nan)
        self.values = np.where(judging, seen.traces[name], np.nan) if name else none
        truth = recording.channels.get(f"{TRUTH}{name}")
        if truth is None or not len(truth.time):
            self.truth = none
        else:
            # The tolerance makes equal instants match despite rounding.
            at = np.searchsorted(truth.time, seen.time + 1e-9, side="right") - 1
            self.truth = truth.values[np.maximum(at, 0)]

    def values_in(self, part: np.ndarray) -> np.ndarray:
        values: np.ndarray = self.values[part]
        kept: np.ndarray = values[np.isfinite(values)]
        return kept

    def kept_in(self, part: np.ndarray, step: float) -> tuple[float, ...]:
        """Estimates at intervals of `SAMPLE_PERIOD`."""
        return tuple(self.values_in(part)[:: max(round(SAMPLE_PERIOD / step), 1)].tolist())

    def errors_in(self, part: np.ndarray) -> Moments:
        """Moments of estimate minus true value in a part of the drive."""
        return Moments.of((self.values - self.truth)[part])

    def truth_in(self, part: np.ndarray) -> float:
        """Mean of the true value in a part of the drive."""
        return Moments.of(self.truth[part]).mean
