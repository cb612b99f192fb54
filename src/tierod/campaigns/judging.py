"""One monitor over one virtual drive, held against the truth: when it alarmed, how exact it was, how long it judged."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.campaigns.figures import Moments, area_under_curve
from tierod.findings import Finding, Status
from tierod.monitors.own_level import OwnLevel
from tierod.monitors.run import Run
from tierod.monitors.session import Conclusion, Monitor, Session, StatusChange, Variant
from tierod.recording import Aligned, Recording
from tierod.vehicles import Vehicle

ALARMS = (Status.RISING, Status.FAULT)
JUDGEMENTS = (Status.HEALTHY, Status.RISING, Status.SUSPECT, Status.FAULT)
"""What a monitor says where it judges; all else says why it does not."""

TRUTH = "truth_"
DEVIATION = "_standard_deviation"
"""A trace X with a trace X_standard_deviation is an estimate; the channel truth_X is what it should be."""

SAMPLE_PERIOD = 5.0
"""Seconds from one kept estimate to the next: friction estimates wander over tens of seconds."""


class Window(NamedTuple):
    """When a fault acts."""

    start: Annotated[float, "s"]
    end: Annotated[float, "s"]


@dataclass(frozen=True)
class Judged:
    """What a monitor made of one drive; every figure of a campaign is made from these.

    Args:
        status: of the final finding
        headline, cause: of the final finding
        value, deviation: of the final estimate, in its unit; NaN where it is withheld
        unit: of the estimate
        ratio: to the own level at the end, NaN where the monitor has none
        outcome: of a drive with a fault: "found", "missed", "early" (an alarm stood already when the fault came) or
            "not judged"; of a sound one: "quiet", "false alarm" or "not judged"
        detection_s, detection_enabled_s: from the fault's start to the first alarm; infinite where there was none
        fault_s, fault_enabled_s: the same to the first verdict "fault"
        false_alarms: alarms that began while no fault had acted yet
        seconds, enabled_s, judged_s: of the drive, in which the monitor learnt, and in which it judged
        sound_s, sound_judged_s: before the fault; judged of these
        truth_sound, truth_faulty: mean of the truth in both phases
        errors_sound, errors_faulty: estimate less truth in both phases, settled; see `Phase`
        area: under the ROC curve between estimates before and in the fault, of this drive
        estimates_sound, estimates_faulty: settled estimates, one every few seconds
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
    sound_s: float
    sound_judged_s: float
    truth_sound: float
    truth_faulty: float
    errors_sound: Moments
    errors_faulty: Moments
    area: float
    estimates_sound: tuple[float, ...]
    estimates_faulty: tuple[float, ...]


def judge(
    recording: Recording,
    monitor: tuple[Monitor, Variant],
    belief: Vehicle,
    own_level: OwnLevel | None,
    fault: Window | None,
    settling: Annotated[float, "s"],
) -> tuple[Judged, OwnLevel | None]:
    """Run a monitor over a drive and hold it against the truth.

    Args:
        recording: measured channels, and the truth in channels prefixed `truth_`
        monitor: and its variant
        belief: what the monitor believes of the car
        own_level: what was learnt of this car before
        fault: when it acts; None in a sound drive
        settling: enabled time from the start of a fault until estimates count as those of the fault [s]

    Returns:
        the judgement, and the own level that the drive has taught, if it has

    Raises:
        TierodError: the recording is not fit for the monitor
    """
    run = Run(*monitor, belief, own_level)
    run.session = tap = _Tap(run.session)
    run.add(recording)
    finding = run.finish().findings[0]
    seen = tap.seen()
    course = run.course or _at_the_end(finding, seen.time)
    return _judged(recording, finding, course, seen, fault, settling, 1.0 / monitor[0].rate), run.learnt


class _Seen(NamedTuple):
    """What a monitor showed over the drive: time, and traces by name, (n,) each."""

    time: np.ndarray
    traces: dict[str, np.ndarray]


class _Tap:
    """A session that also keeps its traces whole."""

    def __init__(self, session: Session):
        self._session = session
        self.signals, self.traces = session.signals, session.traces
        self._time: list[np.ndarray] = []
        self._pieces: list[Mapping[str, np.ndarray]] = []

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        """As the session itself."""
        shown = self._session.absorb(aligned)
        self._time.append(aligned.time)
        self._pieces.append(shown)
        return shown

    def conclude(self) -> Conclusion:
        """As the session itself."""
        return self._session.conclude()

    def seen(self) -> _Seen:
        names = self._pieces[0] if self._pieces else {}
        return _Seen(
            np.concatenate(self._time),
            {name: np.concatenate([piece[name] for piece in self._pieces]) for name in names},
        )


def _at_the_end(finding: Finding, time: np.ndarray) -> tuple[StatusChange, ...]:
    """The course of a monitor that judges a recording as a whole: it says nothing before the end."""
    return (StatusChange(float(time[0]), Status.NOT_READY), StatusChange(float(time[-1]), finding.status))


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
    judging = _during(course, seen.time, JUDGEMENTS)
    start, end = fault or Window(math.inf, math.inf)
    sound, faulty = seen.time < start, (seen.time >= start) & (seen.time < end)
    alarms = _alarms(course, ALARMS)
    first, worst = (_first_after(_alarms(course, wanted), start, end) for wanted in (ALARMS, ALARMS[1:]))
    clock = np.asarray((np.cumsum(enabled) - enabled) * step)
    settled = clock >= settling + float(np.interp(start, seen.time, clock, right=math.inf))
    estimates = _Estimates(recording, seen, judging)
    known = finding.estimate
    ratio = seen.traces.get("ratio_to_own_level")
    return Judged(
        status=str(finding.status),
        headline=finding.headline,
        cause=finding.cause,
        value=known.value if known else math.nan,
        deviation=known.standard_deviation if known else math.nan,
        unit=known.unit if known else "",
        ratio=float(ratio[-1]) if known and ratio is not None and ratio[-1] > 0.0 else math.nan,
        outcome=_outcome(alarms, first, fault, bool(judging[faulty if fault else sound].any())),
        detection_s=first - start if fault else math.nan,
        detection_enabled_s=_enabled_until(first, start, seen.time, clock) if fault else math.nan,
        fault_s=worst - start if fault else math.nan,
        fault_enabled_s=_enabled_until(worst, start, seen.time, clock) if fault else math.nan,
        false_alarms=sum(begin < start for begin, _ in alarms),
        seconds=len(seen.time) * step,
        enabled_s=int(enabled.sum()) * step,
        judged_s=int(judging.sum()) * step,
        sound_s=int(sound.sum()) * step,
        sound_judged_s=int((sound & judging).sum()) * step,
        truth_sound=estimates.truth_in(sound),
        truth_faulty=estimates.truth_in(faulty),
        errors_sound=estimates.errors_in(sound),
        errors_faulty=estimates.errors_in(faulty & settled),
        area=area_under_curve(estimates.values_in(sound), estimates.values_in(faulty & settled)),
        estimates_sound=estimates.kept_in(sound, step),
        estimates_faulty=estimates.kept_in(faulty & settled, step),
    )


class _Estimates:
    """What was estimated where the monitor judged, and the truth at the same instants."""

    def __init__(self, recording: Recording, seen: _Seen, judging: np.ndarray):
        name = next((n for n in seen.traces if n + DEVIATION in seen.traces), None)
        none = np.full(len(seen.time), np.nan)
        self.values = np.where(judging, seen.traces[name], np.nan) if name else none
        truth = recording.channels.get(f"{TRUTH}{name}")
        if truth is None or not len(truth.time):
            self.truth = none
        else:
            at = np.searchsorted(truth.time, seen.time + 1e-9, side="right") - 1
            self.truth = truth.values[np.maximum(at, 0)]

    def values_in(self, part: np.ndarray) -> np.ndarray:
        """Estimates in a part of the drive."""
        values = self.values[part]
        return values[np.isfinite(values)]

    def kept_in(self, part: np.ndarray, step: float) -> tuple[float, ...]:
        """One estimate every few seconds."""
        return tuple(self.values_in(part)[:: max(round(SAMPLE_PERIOD / step), 1)].tolist())

    def errors_in(self, part: np.ndarray) -> Moments:
        """Estimate less truth in a part of the drive."""
        return Moments.of((self.values - self.truth)[part])

    def truth_in(self, part: np.ndarray) -> float:
        """Mean of the truth in a part of the drive."""
        return Moments.of(self.truth[part]).mean


def _during(course: Sequence[StatusChange], time: np.ndarray, statuses: Sequence[Status]) -> np.ndarray:
    """Whether the running verdict was one of the statuses, for each instant."""
    at = np.searchsorted([change.time for change in course], time, side="right") - 1
    wanted = np.array([change.status in statuses for change in course])
    return wanted[np.maximum(at, 0)] & (at >= 0)


def _alarms(course: Sequence[StatusChange], statuses: Sequence[Status]) -> list[Window]:
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


def _first_after(alarms: Sequence[Window], start: float, end: float) -> float:
    """When the first alarm began within a time; infinite where none did, or one stood already."""
    if any(alarm.start < start <= alarm.end for alarm in alarms):
        return math.inf
    return min((alarm.start for alarm in alarms if start <= alarm.start <= end), default=math.inf)


def _outcome(alarms: Sequence[Window], first: float, fault: Window | None, judged: bool) -> str:
    if fault is None:
        return "false alarm" if alarms else "quiet" if judged else "not judged"
    if any(alarm.start < fault.start <= alarm.end for alarm in alarms):
        return "early"
    return "found" if math.isfinite(first) else "missed" if judged else "not judged"


def _enabled_until(alarm: float, start: float, time: np.ndarray, clock: np.ndarray) -> float:
    if not math.isfinite(alarm):
        return math.inf
    begin, end = np.interp((start, alarm), time, clock)
    return float(end - begin)


def plain(judged: Judged) -> dict[str, Any]:
    """As JSON holds it: NaN is null, infinity the text "inf"."""
    return _plain(dataclasses.asdict(judged))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else "inf"
    return value


def from_plain(content: Mapping[str, Any]) -> Judged:
    """What `plain` wrote.

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
