"""Verdicts of every car over its last judged drives: persistent faults, faults to confirm, and faults of before."""

from __future__ import annotations

import datetime as dt
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tierod.core.statuses import SEVERITY, Status

if TYPE_CHECKING:
    import pyarrow as pa

LAST = 3  # Number of last judged drives that are considered

OFTEN = 2  # Number of these with a fault from which the fault is persistent; one if there is only one drive

JUDGED = tuple(each for each in SEVERITY if each.judged)  # Verdicts, the worst first


class Drive(NamedTuple):
    """A drive whose verdict is not healthy."""

    row: int
    name: str  # name of the recording without its folder; "" if unknown
    date: str  # day of its start as an ISO date; "" if unknown
    status: Status  # worst verdict of the drive

    @property
    def key(self) -> object:
        """The drive itself: its name or, where that is unknown, its row."""
        return self.name or self.row

    @property
    def place(self) -> str:
        """Name and date."""
        return ", ".join(filter(None, (self.name or "a drive", self.date)))

    @property
    def text(self) -> str:
        """Name, date and verdict."""
        return f"{self.place}: {self.status}"


@dataclass(frozen=True)
class Standing:
    """Last verdicts of a monitor on one element of a car, of which at least one ever was not healthy."""

    vehicle: str  # vehicle, monitor, judged: the car, the monitor, and the judged element; "" for the whole
    monitor: str
    judged: str
    of: int  # number of last judged drives that are considered
    drives: tuple[Drive, ...]  # those of them that are not healthy, in the order of time
    earlier: tuple[Drive, ...]  # drives before these that were not healthy, in the order of time
    # kind, action: kind of fault and recommended action of the worst and latest of `drives`, else of `earlier`
    kind: str
    action: str
    now: Status  # worst verdict of the last judged drives

    @property
    def faults(self) -> int:
        """Number of the last judged drives with a fault."""
        return sum(each.status is Status.FAULT for each in self.drives)

    @property
    def persistent(self) -> bool:
        """Whether the fault is persistent; else the drives that are not healthy are to be confirmed."""
        return self.faults >= min(OFTEN, self.of)

    @property
    def history(self) -> str:
        """What was found before, of an element in whose last judged drives nothing was found; else ""."""
        if self.drives:
            return ""
        before = f"{counted(each.status for each in self.earlier)}, the last in {self.earlier[-1].text}"
        return f"{self.subject}: {self.now} in {drives_in_words(self.of)}; before that {before}"

    @property
    def subject(self) -> str:
        """The judged element or, for a verdict on the whole, the monitor."""
        return self.judged or f"monitor {self.monitor}"


def drives_in_words(count: int) -> str:
    """The last judged drives as part of a sentence: "the last 3 judged drives"."""
    return "the last judged drive" if count == 1 else f"the last {count} judged drives"


def counted(statuses: Iterable[Status]) -> str:
    """Number of drives by verdict, the worst first: "2 faults, 1 suspect"."""
    counts = Counter(statuses)
    plural = {Status.FAULT: "s"}
    return ", ".join(f"{n} {each}{plural.get(each, '') * (n > 1)}" for each in JUDGED if (n := counts[each]))


def standings(findings: pa.Table) -> list[Standing]:
    """Verdicts of every car, monitor and element that were not always healthy, persistent faults first.

    A drive without a verdict counts neither as healthy nor as faulty. Of drives with equal time stamps the order is
    unknown, as it is of drives without a date among dated ones: all that may be among the last `LAST` are considered.
    """
    table = _drives(findings)
    found = [_standing(findings, table, first, end) for first, end in _groups(table)]
    return sorted(found, key=lambda each: (-each.persistent, -each.faults, each.vehicle))


class _Drives(NamedTuple):
    """Judged drives, one row for each car, monitor, element and recording, sorted by these and time, (drives,) each."""

    group: np.ndarray  # number of the combination of car, monitor and element
    start: np.ndarray  # start in microseconds since 1970; `_UNDATED` without a date
    severity: np.ndarray  # place of the worst verdict in `JUDGED`
    row: np.ndarray  # row of that verdict in the findings


_UNDATED = np.iinfo(np.int64).min

_QUIET = sum(each.alarm for each in JUDGED)


def _drives(findings: pa.Table) -> _Drives:
    import pyarrow as pa
    import pyarrow.compute as pc

    severity = pc.index_in(findings["status"], pa.array([str(each) for each in JUDGED])).fill_null(-1).to_numpy()
    rows = np.flatnonzero(severity >= 0)
    if not len(rows):
        return _Drives(*(np.zeros(0, np.int64) for _ in range(4)))
    names = ("vehicle", "monitor", "judged", "recording_name")
    codes = [findings[name].take(rows).combine_chunks().dictionary_encode().indices for name in names]
    # A finding that names no recording is a drive of its own.
    unnamed = -1 - np.arange(len(rows))
    group = np.unique(np.stack([code.fill_null(-1).to_numpy() for code in codes[:3]]), axis=1, return_inverse=True)[1]
    recording = np.where(codes[3].is_null(), unnamed, codes[3].fill_null(0).to_numpy())
    start = findings["start"].take(rows).cast(pa.timestamp("us", tz="UTC")).cast(pa.int64())
    time = start.fill_null(_UNDATED).to_numpy()
    # One row for each group and recording: that of its worst verdict, of several the last one.
    order = np.lexsort((-rows, severity[rows], recording, group.ravel()))
    key = np.stack((group.ravel(), recording))[:, order]
    first = np.concatenate(([True], np.any(np.diff(key, axis=1) != 0, axis=0)))
    begin = np.minimum.reduceat(time[order], np.flatnonzero(first))
    chosen = order[first]
    by_time = np.lexsort((rows[chosen], begin, group.ravel()[chosen]))
    chosen, begin = chosen[by_time], begin[by_time]
    return _Drives(group.ravel()[chosen], begin, severity[rows][chosen], rows[chosen])


def _groups(table: _Drives) -> Iterator[tuple[int, int]]:
    change = np.flatnonzero(np.diff(table.group)) + 1
    for first, end in pairwise([0, *change.tolist(), len(table.group)]):
        if end > first and table.severity[first:end].min() < _QUIET:
            yield first, end


def _standing(findings: pa.Table, table: _Drives, first: int, end: int) -> Standing:
    bad = table.severity[first:end] < _QUIET
    recent = _recent(table.start[first:end])
    last = tuple(_drive(findings, table, place) for place in (first + np.flatnonzero(bad & recent)).tolist())
    before = tuple(_drive(findings, table, place) for place in (first + np.flatnonzero(bad & ~recent)).tolist())
    worst = min(reversed(last or before), key=lambda each: JUDGED.index(each.status))
    names = ("vehicle", "monitor", "judged", "kind", "action")
    vehicle, monitor, judged, kind, action = (findings[name][worst.row].as_py() or "" for name in names)
    now = JUDGED[table.severity[first:end][recent].min()]
    return Standing(vehicle, monitor, judged, int(recent.sum()), last, before, kind, action, now)


def _drive(findings: pa.Table, table: _Drives, place: int) -> Drive:
    row, start = int(table.row[place]), int(table.start[place])
    name = (findings["recording_name"][row].as_py() or "").rstrip("/").rpartition("/")[2]
    date = "" if start == _UNDATED else str((dt.datetime(1970, 1, 1) + dt.timedelta(microseconds=start)).date())
    return Drive(row, name, date, JUDGED[table.severity[place]])


def _recent(start: np.ndarray) -> np.ndarray:
    """Which drives of a group may be among the last `LAST`, given their starts in ascending order."""
    dated = start != _UNDATED
    recent = np.zeros(len(start), bool)
    for of in (~dated, dated):
        recent[np.flatnonzero(of)[-LAST:]] = True
    known = start[dated]
    if len(known) > LAST:
        recent |= dated & (start >= known[-LAST])
    return recent
