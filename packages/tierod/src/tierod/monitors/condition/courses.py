"""Statements over the samples of a recording: episodes of faults, courses of trouble codes, and kinds in words."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tierod.core.findings import Episode, Estimate, Status
from tierod.core.graph import Result
from tierod.core.series import runs
from tierod.core.signals import SIGNALS
from tierod.core.statuses import STATUSES
from tierod.monitors.condition.kinds import DELAY, DRIFT, GAIN, LOSS, LOST_TORQUE, NOISE, OFFSET, OUTLIER, STUCK
from tierod.monitors.condition.reaction import LEAST_DOUBT
from tierod.monitors.condition.signals import ELEMENTS
from tierod.monitors.session import StatusChange

FAULT, SUSPECT, HEALTHY, NOT_TESTABLE, NOT_AVAILABLE = (
    STATUSES.index(each)
    for each in (Status.FAULT, Status.SUSPECT, Status.HEALTHY, Status.NOT_TESTABLE, Status.NOT_AVAILABLE)
)
"""Codes of the statuses that the monitor uses."""


class StatementCourse(NamedTuple):
    """Statements over n samples, one column for each of `ELEMENTS`."""

    status: np.ndarray  # indices in `STATUSES`
    testable: np.ndarray  # whether a fault would show
    spread: np.ndarray  # deviations by which that is judged, see `Judged`
    kind: np.ndarray  # number of the kind; 0 where none is identified
    magnitude: np.ndarray  # magnitude, deviation: magnitude of the fault, and its standard deviation
    deviation: np.ndarray
    low_grip: np.ndarray  # whether the tyres slid, so that no fault was declared, (n,)
    # evidence for a fault, see `Judged.lead`, (n,) [nat per sample, or a share]; NaN where nothing is judged
    lead: np.ndarray
    # since, supported: times in the recording at which the evidence for the status began, and until which residuals
    # supported a fault, NaN without evidence for one [s]
    since: np.ndarray
    supported: np.ndarray
    ended: np.ndarray  # whether residuals have contradicted a declared fault since then

    @classmethod
    def of(cls, result: Result, time: np.ndarray, running: np.ndarray) -> StatementCourse:
        def columns(before: str, after: str = "") -> np.ndarray:
            return np.column_stack([result[f"{before}.{name}{after}"] for name in ELEMENTS])

        begun, supported = (time - running)[:, None], columns("supported")
        return cls(
            np.rint(columns("statements", ".status")).astype(int),
            columns("testable") > 0.5,
            columns("spread"),
            columns("statements", ".kind"),
            columns("statements", ".magnitude"),
            columns("statements", ".deviation"),
            result["low_grip"] > 0.5,
            result["lead"],
            begun + np.maximum(columns("statements", ".since"), 0.0),
            np.where(supported < 0.0, np.nan, begun + supported),
            columns("ended") > 0.5,
        )

    @classmethod
    def unjudged(cls, count: int) -> StatementCourse:
        """Statements over samples that are not judged: not testable."""
        no, unknown = np.zeros((count, len(ELEMENTS)), bool), np.full((count, len(ELEMENTS)), np.nan)
        status, no_kind = np.full(no.shape, NOT_TESTABLE), np.zeros(no.shape)
        return cls(status, no, unknown, no_kind, unknown, unknown, no[:, 0], unknown[:, 0], unknown, unknown, no)

    def where_available(self, available: np.ndarray, moving: np.ndarray) -> StatementCourse:
        """Statements with "not available" where an element has no signal; a declared fault is kept."""
        testable = self.testable & available & moving[:, None]
        quiet = np.where(testable, HEALTHY, NOT_TESTABLE)
        status = np.select(
            [self.status == FAULT, ~available, self.status == SUSPECT], [FAULT, NOT_AVAILABLE, SUSPECT], quiet
        )
        return self._replace(status=status, testable=testable)


TOGETHER = 0.3  # shortest gap between two episodes of one element [s]; with a shorter gap they are one episode
SHARE = 0.5  # least share of an episode over which another element must be a candidate as well to be named with it [-]


@dataclass
class Span:
    """Consecutive samples in which an element is declared, or is a candidate."""

    start: float  # start, end: begin and end of the run [s]
    end: float
    onset: float  # onset, supported: likeliest onset of the fault, and time until which residuals supported it [s]
    supported: float
    count: int  # number of samples
    others: np.ndarray  # for each element, the number of these samples at which it was a candidate
    # for each kind, 0 for none, the number of samples at which it was identified, with its last magnitude and standard
    # deviation
    kinds: dict[float, tuple[int, float, float]] = field(default_factory=dict)
    ended: bool = False  # whether residuals have contradicted the declared fault since then
    followed: bool = True  # whether there was evidence for it ever since

    @property
    def kind(self) -> tuple[float, float, float]:
        """Kind that was identified for the longest time, or 0 for none, with magnitude and standard deviation.

        The first samples are too few to identify a kind, and the last ones belong to the recovery of the sensor.
        """
        kind = max(self.kinds, key=lambda each: (self.kinds[each][0], each > 0.5, -each), default=0.0)
        return (kind, *self.kinds[kind][1:]) if self.kinds else (0.0, np.nan, np.nan)

    @property
    def sign(self) -> float:
        """Whether the reading is too large (1) or too small (-1); 0 if its kind has no sign."""
        kind, magnitude, _ = self.kind
        if kind not in (OFFSET, DRIFT, GAIN) or not np.isfinite(magnitude):
            return 0.0
        return float(np.sign(magnitude - 1.0 if kind == GAIN else magnitude))

    def add(self, kind: float, count: int, magnitude: float, deviation: float) -> None:
        self.kinds[kind] = (self.kinds.get(kind, (0,))[0] + count, magnitude, deviation)

    def joined(self, new: Span) -> None:
        self.onset, self.others = min(self.onset, new.onset), self.others + new.others
        self.end, self.supported, self.ended, self.followed = new.end, new.supported, new.ended, True
        self.count += new.count
        for kind, (count, magnitude, deviation) in new.kinds.items():
            self.add(kind, count, magnitude, deviation)

    def follow(self, supported: np.ndarray, period: float) -> None:
        """Extend a fault beyond its declaration: a rule withdraws it while a symptom is missing."""
        gone = np.flatnonzero(np.isnan(supported))
        count = int(gone[0]) if len(gone) else len(supported)
        if self.followed and count:
            self.supported = float(supported[count - 1]) + period
        self.followed = self.followed and not len(gone)

    def episode(self, element: str, last: float, period: float, others: tuple[str, ...]) -> Episode:
        kind, value, deviation = self.kind
        words, quantity, unit, factor = _described(element, kind, value)
        size = None
        if quantity and np.isfinite(value):
            name = f"{quantity} of {element.replace('_', ' ')}"
            size = Estimate(name, factor * value, factor * deviation, unit)
        lasts = max(self.end, self.supported) >= last and not self.ended
        end = None if lasts else max(self.supported, self.onset + period)
        return Episode(words, self.onset, end, size, others, self.start)


def _described(element: str, kind: float, magnitude: float) -> tuple[str, str, str, float]:
    """Kind of a fault and its magnitude in words, "" without one; its unit, and the factor to that unit."""
    unit = SIGNALS[element].unit if element in SIGNALS else ""
    found: dict[float, tuple[str, str, str]] = {
        LOSS: ("total loss", "", ""),
        STUCK: ("stuck", "", ""),
        OFFSET: (f"{'positive' if magnitude > 0.0 else 'negative'} offset", "offset", unit),
        GAIN: ("wrong gain", "reading over truth", ""),
        DRIFT: ("drift", "growth of the error", f"{unit}**2" if unit.endswith("/s") else f"{unit}/s"),
        OUTLIER: ("outlier", "reading over truth", ""),
        NOISE: ("noise", "standard deviation of the noise", unit),
        DELAY: ("delay", "delay", "s"),
        LOST_TORQUE: ("loss of torque", "lost share of the torque", "percent"),
    }
    return (*found.get(kind, ("", "", "")), 100.0 if kind == LOST_TORQUE else 1.0)


@dataclass
class ElementCourse:
    """Course of one element over a recording."""

    element: str  # name of the element
    period: float  # sampling interval [s]
    faults: list[Span] = field(default_factory=list)
    doubts: list[Span] = field(default_factory=list)
    course: list[StatusChange] = field(default_factory=list)
    testable_samples: int = 0
    spreads: float = 0.0  # sum of the standard deviations that decide it, see `Judged`, over the testable samples
    available_samples: int = 0
    observed: float = -np.inf  # time of the last sample at which a fault would have shown [s]

    @property
    def testable(self) -> float:
        return self.testable_samples * self.period

    @property
    def spread(self) -> float:
        """Mean standard deviation of reading less prediction, or of the lost share of torque, while it was testable."""
        return self.spreads / max(self.testable_samples, 1)

    @property
    def available(self) -> float:
        """Time for which the sensor was read, or the target of the actuator was known [s]."""
        return self.available_samples * self.period

    def add(self, time: np.ndarray, stated: StatementCourse, available: np.ndarray) -> None:
        place = ELEMENTS.index(self.element)
        status, testable = stated.status[:, place], stated.testable[:, place]
        self.available_samples += int(np.count_nonzero(available))
        self.testable_samples += int(np.count_nonzero(testable))
        self.spreads += float(stated.spread[testable, place].sum())
        self.observed = float(time[testable][-1]) if testable.any() else self.observed
        self._extend(self.faults, time, status == FAULT, stated, place)
        self._extend(self.doubts, time, status == SUSPECT, stated, place)
        for at in np.flatnonzero(np.diff(status, prepend=-1)).tolist():
            reached = STATUSES[status[at]]
            if not self.course or self.course[-1].status is not reached:
                self.course.append(StatusChange(float(time[at]), reached))

    def _extend(
        self, spans: list[Span], time: np.ndarray, there: np.ndarray, stated: StatementCourse, place: int
    ) -> None:
        begins, ends = (each.tolist() for each in runs(there))
        supported = stated.supported[:, place]
        if spans:
            spans[-1].follow(supported[: (*begins, len(time))[0]], self.period)
        for start, stop, following in zip(begins, ends, [*begins, len(time)][1:], strict=True):
            new = Span(
                float(time[start]),
                float(time[stop - 1]) + self.period,
                min(float(stated.since[stop - 1, place]), float(time[start])),
                float(np.nan_to_num(supported[stop - 1], nan=time[stop - 1])) + self.period,
                stop - start,
                (stated.status[start:stop] == SUSPECT).sum(axis=0),
                ended=bool(stated.ended[stop - 1, place]),
            )
            kinds = stated.kind[start:stop, place]
            for kind in np.unique(kinds).tolist():
                at = start + np.flatnonzero(kinds == kind)
                new.add(kind, len(at), float(stated.magnitude[at[-1], place]), float(stated.deviation[at[-1], place]))
            # Evidence that was never forgotten in between is that of one fault.
            if spans and min(new.start - TOGETHER, new.onset - self.period) < spans[-1].end:
                spans[-1].joined(new)
            else:
                spans.append(new)
            spans[-1].follow(supported[stop:following], self.period)

    def episodes(self, end: float, alone: bool = False) -> tuple[Episode, ...]:
        """Episodes of faults and of doubts between several elements, in the order of time; or doubts about this alone.

        `end` is the end of the recording [s].
        """
        spans: list[tuple[Span, tuple[str, ...]]] = [] if alone else [(each, ()) for each in self.faults]
        spans += [(each, others) for each, others in self._lasting() if alone == (not others)]
        last = end - 1.5 * self.period
        found = [each.episode(self.element, last, self.period, others) for each, others in spans]
        return tuple(sorted(found, key=lambda episode: episode.declared_at))

    def _lasting(self) -> list[tuple[Span, tuple[str, ...]]]:
        """Lasting doubts, and the other elements that may be faulty instead."""
        found = []
        for each in self.doubts:
            beside = zip(ELEMENTS, each.others > SHARE * each.count, strict=True)
            if each.end - each.start >= LEAST_DOUBT:
                found.append((each, tuple(name for name, there in beside if there and name != self.element)))
        return found

    def declare(
        self,
        span: tuple[float, float, float],
        kind: float,
        magnitude: tuple[float, float],
        rivals: Collection[str] = (),
    ) -> None:
        """Add a fault detected by a check beside the bank, or a doubt between several elements."""
        start, found, end = span
        fault = Span(found, max(found, end), start, end, 1, np.array([float(each in rivals) for each in ELEMENTS]))
        fault.add(kind, 1, *magnitude)
        (self.doubts if rivals else self.faults).append(fault)
        reached = Status.SUSPECT if rivals else Status.FAULT
        self.course[:] = [*(each for each in self.course if each.time < found), StatusChange(found, reached)]

    def brief(self, longest: float, times: Sequence[tuple[float, float, float]], alike: Collection[str]) -> list[Span]:
        """Faults that lasted for less than a time, and of which onset or declaration was in one of several spans.

        The spans [s] have the sign of the errors that belong to them, 0 for both; `alike` are elements with which a
        doubt counts as well.
        """
        doubts = [(each, each.end) for each, others in self._lasting() if {*others} <= {*alike}]
        return [
            each
            for each, until in (*((each, each.supported) for each in self.faults), *doubts)
            if until - each.onset < longest
            and any(start <= each.start and each.onset <= end and sign * each.sign >= 0.0 for start, end, sign in times)
        ]

    def forget(self, start: float, end: float) -> bool:
        """Withdraw faults and doubts that began in a time in which an input of the filters was faulty."""
        withdrawn = any(start <= each.declared_at <= end for each in self.episodes(np.inf))
        for spans in (self.faults, self.doubts):
            spans[:] = [each for each in spans if not start <= each.start <= end]
        course, self.course = self.course, []
        for each in course:
            gone = start <= each.time <= end and each.status in (Status.FAULT, Status.SUSPECT)
            new = StatusChange(each.time, Status.NOT_TESTABLE) if gone else each
            if not self.course or self.course[-1].status is not new.status:
                self.course.append(new)
        return withdrawn
