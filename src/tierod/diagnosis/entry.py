"""Entry of a fault memory for one trouble code."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.diagnosis.status import CLEARED, CodeStatus, after_test, at_cycle_end, at_cycle_start, passed_this_cycle
from tierod.diagnosis.trouble_codes import TroubleCode


@dataclass(frozen=True)
class FreezeFrame:
    """Signals around the instant at which a test failed.

    Args:
        cycle: number of the operation cycle
        date: when that cycle began, ISO 8601
        instant: at which the test failed, in the time of the recording [s]
        time: of the values, from the instant on [s], negative before it
        values: by signal, one per time, SI; None where nothing was measured
    """

    cycle: int
    date: str
    instant: float
    time: tuple[float, ...]
    values: Mapping[str, tuple[float | None, ...]]

    def at_instant(self) -> dict[str, float | None]:
        """Each signal's last value measured up to the instant."""
        found: dict[str, float | None] = {}
        for name, values in self.values.items():
            until = [value for at, value in zip(self.time, values, strict=True) if at <= 1e-9 and value is not None]
            found[name] = until[-1] if until else None
        return found


@dataclass(frozen=True)
class Entry:
    """Entry of one trouble code.

    Args:
        status: its status byte
        counter: of the debouncing, -128 to 127
        verdict: that holds: 1 failed, -1 passed, 0 none yet
        occurrences: how often the test changed to failed since the memory was cleared
        failed_cycles: in a row, up to confirmation
        passed_cycles: in a row, for healing and then for aging
        healed: whether the lamp is let go, and aging has begun
        consequence_of: name of the code that caused the latest failure, until a test passes; "" where none did
        first, last: freeze frame of the first and of the latest failure
    """

    status: CodeStatus = CLEARED
    counter: int = 0
    verdict: int = 0
    occurrences: int = 0
    failed_cycles: int = 0
    passed_cycles: int = 0
    healed: bool = False
    consequence_of: str = ""
    first: FreezeFrame | None = None
    last: FreezeFrame | None = None

    @property
    def stored(self) -> bool:
        """Whether it takes a place in the memory: it is pending or confirmed, and was not displaced since."""
        return bool(self.status & (CodeStatus.PENDING | CodeStatus.CONFIRMED))

    def with_(self, **changes: Any) -> Entry:
        """The entry with some of its fields replaced."""
        return dataclasses.replace(self, **changes)

    def document(self) -> dict[str, Any]:
        """The entry as the file holds it."""
        content = dataclasses.asdict(self)
        content["status"] = int(self.status)
        return content

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Entry:
        """The entry that a file holds.

        Raises:
            ValueError: it is not an entry
        """
        names = {each.name for each in dataclasses.fields(cls)}
        if set(content) != names:
            raise ValueError(f"{min(set(content) ^ names)} is missing or not known")
        for name, (least, most) in _RANGES.items():
            if not (_is_whole(content[name]) and least <= content[name] <= most):
                raise ValueError(f"{name} is {content[name]!r}, no whole number from {least} to {most}")
        if not (isinstance(content["healed"], bool) and isinstance(content["consequence_of"], str)):
            raise ValueError("healed is not true or false, or consequence_of is no name")
        frames = {name: _frame(content[name]) for name in ("first", "last")}
        return cls(**{**content, "status": CodeStatus(content["status"]), **frames})


_MOST = 2**31 - 1
"""Cycles and failures of a car's life are far fewer."""

_RANGES = {
    "status": (0, 255),
    "counter": (-128, 127),
    "verdict": (-1, 1),
    "occurrences": (0, _MOST),
    "failed_cycles": (0, _MOST),
    "passed_cycles": (0, _MOST),
}


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_finite(value: object) -> bool:
    """Whether it is a number that a float holds: JSON has neither a largest number nor, in Python, NaN."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def _frame(content: object) -> FreezeFrame | None:
    if content is None:
        return None
    if not isinstance(content, dict) or set(content) != {each.name for each in dataclasses.fields(FreezeFrame)}:
        raise ValueError("a freeze frame is not whole")
    time, values = content["time"], {name: tuple(each) for name, each in content["values"].items()}
    if not (
        _is_whole(content["cycle"])
        and isinstance(content["date"], str)
        and all(map(_is_finite, [content["instant"], *time]))
        and all(len(each) == len(time) for each in values.values())
        and all(value is None or _is_finite(value) for each in values.values() for value in each)
    ):
        raise ValueError("a freeze frame holds something other than dates and finite numbers")
    return FreezeFrame(**{**content, "time": tuple(time), "values": values})


def failed(entry: Entry, code: TroubleCode) -> Entry:
    """The entry after its test has failed."""
    again = bool(entry.status & CodeStatus.FAILED_THIS_CYCLE)
    cycles = min(entry.failed_cycles + (not again), code.confirmation_cycles)
    status = after_test(entry.status, failed=True)
    if cycles >= code.confirmation_cycles:
        status |= CodeStatus.CONFIRMED
    if status & CodeStatus.CONFIRMED and code.lamp:
        status |= CodeStatus.WARNING_REQUESTED
    occurrences = entry.occurrences + (not entry.status & CodeStatus.TEST_FAILED)
    return entry.with_(
        status=status,
        verdict=1,
        occurrences=occurrences,
        failed_cycles=cycles,
        passed_cycles=0,
        healed=False,
        consequence_of="",
    )


def displaced(entry: Entry) -> Entry:
    """The entry after it made room for another: no longer kept, but the present result of its test still stands."""
    gone = CodeStatus.PENDING | CodeStatus.CONFIRMED | CodeStatus.WARNING_REQUESTED
    return Entry(status=entry.status & ~gone, counter=entry.counter, verdict=entry.verdict)


def begun(entry: Entry) -> Entry:
    """The entry at the beginning of an operation cycle: tests start anew, what was found before stays."""
    return entry.with_(status=at_cycle_start(entry.status), counter=0, verdict=0)


def ended(entry: Entry, code: TroubleCode) -> Entry:
    """The entry at the end of an operation cycle: passed cycles let the lamp go, and then the code itself.

    A code that never asked for the lamp ages from its first passed cycle on. A cycle in which the test failed as the
    consequence of another is no step towards healing.
    """
    status = at_cycle_end(entry.status)
    if not passed_this_cycle(entry.status) or entry.consequence_of:
        return entry.with_(status=status)
    entry = entry.with_(status=status, failed_cycles=0, passed_cycles=entry.passed_cycles + 1)
    if not status & CodeStatus.CONFIRMED:
        return entry.with_(passed_cycles=0)
    if not entry.healed and not status & CodeStatus.WARNING_REQUESTED:
        entry = entry.with_(healed=True)
    if not entry.healed and entry.passed_cycles >= code.healing_cycles:
        return entry.with_(status=status & ~CodeStatus.WARNING_REQUESTED, healed=True, passed_cycles=0)
    if entry.healed and entry.passed_cycles >= code.aging_cycles:
        return Entry(status=status & ~CodeStatus.CONFIRMED)
    return entry


BEFORE, AFTER = 2.0, 1.0
"""What a freeze frame shows around the instant of the failure [s]."""

MOST = 61
"""Values per signal in a frame."""


class Window:
    """Signals of the last moments."""

    def __init__(self) -> None:
        self.time = np.zeros(0)
        self.values: dict[str, np.ndarray] = {}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """More samples, later than those before; a signal that a piece lacks is missing there."""
        old, new = len(self.time), len(time)
        self.time = np.concatenate([self.time, time])
        for name in {**self.values, **signals}:
            before = self.values.get(name, np.full(old, np.nan))
            self.values[name] = np.concatenate([before, signals.get(name, np.full(new, np.nan))])

    def forget(self, until: float) -> None:
        """Drop what lies before a time [s]."""
        first = int(np.searchsorted(self.time, until))
        self.time = self.time[first:]
        self.values = {name: values[first:] for name, values in self.values.items()}

    def frame(self, cycle: int, date: str, instant: float) -> FreezeFrame:
        """Freeze frame of the signals around an instant [s], thinned out so that the instant stays."""
        begin = int(np.searchsorted(self.time, instant - BEFORE))
        end = int(np.searchsorted(self.time, instant + AFTER, "right"))
        centre = max(int(np.searchsorted(self.time, instant + 1e-9)) - 1, begin)
        stride = max(-(-(end - begin) // MOST), 1)
        kept = np.arange(begin + (centre - begin) % stride, end, stride)
        values = {
            name: tuple(float(value) if np.isfinite(value) else None for value in each[kept])
            for name, each in self.values.items()
        }
        return FreezeFrame(cycle, date, instant, tuple(np.round(self.time[kept] - instant, 6).tolist()), values)
