"""Frames of a live bus, the common time of a drive from their stamps, and the count of lost ones."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.series import CALENDAR
from tierod.io.readers.frames import Frames, identifier_text, messages


class Frame(NamedTuple):
    """Frame as a bus delivered it."""

    time: Annotated[float, "s"]  # time stamp of the bus; after `DriveClock.placed` the time in the drive
    identifier: int  # identifier, with the bit EXTENDED set for 29 bits
    bus: int  # number of the bus, from 1
    data: bytes


class Notice(NamedTuple):
    """Event on a bus: "lost", "back", "error frame" or "ended"."""

    bus: int  # number of the bus, from 1
    what: str
    text: str


def frames_of(parts: Sequence[Frame], origin: float) -> Frames:
    """Arrays of some frames, in the order in which they are given.

    Args:
        origin: calendar time of the stamp zero [s]
    """
    buses = sorted({part.bus for part in parts})
    number = {bus: place for place, bus in enumerate(buses)}
    length = np.array([len(part.data) for part in parts])
    width = max(8, int(length.max()))
    payload = np.frombuffer(b"".join(part.data.ljust(width, b"\0") for part in parts), np.uint8)
    return Frames(
        np.array([part.time for part in parts]),
        np.array([part.identifier for part in parts], dtype=np.uint32),
        np.array([number[part.bus] for part in parts], dtype=np.uint16),
        payload.reshape(len(parts), width),
        length,
        tuple(f"CAN{bus}" for bus in buses),
        origin,
    )


@dataclass(frozen=True)
class ClockTuning:
    """Limits beyond which a time difference counts as a jump of the clock."""

    # a stamp earlier than the newest by more is a jump; by less, a frame out of order, which a log can sort
    back: Annotated[float, "s"] = 0.3
    # a stamp is a jump if it advanced by this much more than the computer's clock did
    ahead: Annotated[float, "s"] = 5.0
    # a bus whose first stamp deviates by more from the other buses has a clock of its own
    apart: Annotated[float, "s"] = 2.0


@dataclass
class _Bus:
    """Clock of one bus: offset of its stamps, newest stamp in the drive, and computer's clock at its arrival [s]."""

    added: float
    newest: float
    came: float


@dataclass
class DriveClock:
    """Converts the stamps of all buses into the time of the drive, which begins at the whole second of the first stamp.

    `origin` is the calendar time of zero [s]. `jumps` counts jumps of a clock, `late` frames out of order, `doubled`
    repeated frames; `latest` is the newest stamp in the drive [s].
    """

    tuning: ClockTuning = field(default_factory=ClockTuning)
    origin: float = 0.0
    jumps: int = 0
    late: int = 0
    doubled: int = 0
    latest: float = -math.inf
    _buses: dict[int, _Bus] = field(default_factory=dict)
    _zero: float = math.nan
    _last: dict[tuple[int, int], Frame] = field(default_factory=dict)

    def placed(self, frame: Frame, came: float, calendar: float) -> Frame | None:
        """The frame with its time in the drive; None where its stamp is not finite.

        Args:
            came: time of arrival by the computer's clock [s]
            calendar: calendar time of the computer [s]
        """
        if not math.isfinite(frame.time):
            return None
        bus = self._buses.get(frame.bus) or self._opened(frame, came, calendar)
        time = frame.time - self._zero + bus.added
        if time < bus.newest - self.tuning.back or time - bus.newest > came - bus.came + self.tuning.ahead:
            expected = bus.newest + max(came - bus.came, 0.0)
            bus.added += expected - time
            self.jumps += 1
            time = expected
        elif time < bus.newest:
            self.late += 1
        if time >= bus.newest:
            bus.newest, bus.came = time, came
        placed = Frame(time, frame.identifier, frame.bus, frame.data)
        key = (frame.bus, frame.identifier)
        self.doubled += self._last.get(key) == placed
        self._last[key] = placed
        self.latest = max(self.latest, time)
        return placed

    def begin(self, frame: Frame, came: float, calendar: float) -> None:
        """Set the origin from the first frame of a drive; arguments as in `placed`."""
        if math.isfinite(frame.time):
            self._opened(frame, came, calendar)

    def _opened(self, frame: Frame, came: float, calendar: float) -> _Bus:
        if math.isnan(self._zero):
            self._zero = math.floor(frame.time)
            # A bus that stamps with the time since its start gives no date: the computer's calendar does.
            self.origin = float(self._zero if self._zero > CALENDAR else math.floor(calendar))
        added, time = 0.0, frame.time - self._zero
        others = [other.newest + came - other.came for other in self._buses.values()]
        if others and abs(time - others[0]) > self.tuning.apart:
            added = others[0] - time
        made = self._buses[frame.bus] = _Bus(added, time + added, came)
        return made


_SETTLING = 20  # Number of gaps between frames after which the learnt period is used

_SPREAD, _MOST = 0.3, 0.7
"""Relative spread around the median gap, and the share of gaps that must lie within it for a message to be periodic;
lost frames are counted for periodic messages only, not for bursts.
"""

NAMED = 4  # Number of messages named in a sentence about messages that fell silent together


@dataclass
class _Message:
    """Newest stamp [s], learnt period [s], and number of gaps seen of one message."""

    newest: float
    period: float = math.nan
    seen: int = 0


@dataclass(frozen=True)
class Gap:
    """Silence of a message that has returned."""

    identifier: int
    bus: str
    seconds: Annotated[float, "s"]


def sentences(gaps: Iterable[Gap]) -> list[str]:
    """One sentence per bus on the messages that fell silent, however many they are."""
    of_bus: dict[str, list[Gap]] = {}
    for gap in gaps:
        of_bus.setdefault(gap.bus, []).append(gap)
    found = []
    for bus, silent in of_bus.items():
        names = [identifier_text(gap.identifier) for gap in silent]
        some = ", ".join(names[:NAMED]) + f" and {len(names) - NAMED} more" * (len(names) > NAMED)
        found.append(f"{some} on {bus}: not received for {max(gap.seconds for gap in silent):.2g} s")
    return found


class Gaps:
    """Learns the period of every message, and counts the frames that are missing.

    Args:
        silence: gap beyond which a message has fallen silent, as during the restart of a control unit
        factor: gap in periods beyond which a frame counts as lost
    """

    def __init__(self, silence: Annotated[float, "s"] = 1.0, factor: float = 1.8):
        self.silence, self.factor = silence, factor
        self.lost = 0
        self._messages: dict[tuple[str, int], _Message] = {}

    def add(self, frames: Frames) -> list[Gap]:
        """Add frames in the order of time, and return the silences that ended among them."""
        found = []
        for identifier, bus, rows in messages(frames):
            name, times = frames.buses[bus], frames.time[rows]
            known = self._messages.setdefault((name, identifier), _Message(float(times[0])))
            gaps = np.diff(times, prepend=known.newest)
            gaps = gaps[gaps > 0.0]
            known.newest = float(times[-1])
            if not len(gaps):
                continue
            usual = float(np.median(gaps))
            # Bounded: the only gap of a short piece may be a dropout, which would stretch the learnt period.
            known.period = usual if known.seen < _SETTLING else 0.9 * known.period + 0.1 * min(usual, 2 * known.period)
            known.seen += len(gaps)
            if known.seen < _SETTLING or known.period > self.silence / 3.0:
                continue
            regular = float(np.mean(np.abs(gaps - usual) < _SPREAD * usual)) > _MOST
            wide = gaps[gaps > self.factor * known.period]
            if regular:
                # Delayed frames are followed by shorter gaps; these are not counted as lost.
                crowded = int(np.count_nonzero(gaps < known.period / self.factor))
                missed = int(np.round(wide[wide <= self.silence] / known.period - 1.0).sum())
                self.lost += max(missed - crowded, 0)
            found += [Gap(identifier, name, float(gap)) for gap in wide[wide > self.silence]]
        return found
