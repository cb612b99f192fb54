"""Common time of a drive from the time stamps of its buses; jumps of a clock are bridged and counted."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

from tierod.core.timestamps import CALENDAR
from tierod.live.frame import Frame


@dataclass(frozen=True)
class ClockTuning:
    """Limits beyond which a time difference counts as a jump of the clock.

    Args:
        back: a stamp earlier than the newest by more is a jump; by less, a frame out of order, which a log can sort
        ahead: a stamp is a jump if it advanced by this much more than the computer's clock did
        apart: a bus whose first stamp deviates by more from the other buses has a clock of its own
    """

    back: Annotated[float, "s"] = 0.3
    ahead: Annotated[float, "s"] = 5.0
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
