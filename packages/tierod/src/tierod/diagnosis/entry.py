"""Entry of a fault memory for one trouble code."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntFlag
from functools import cache
from typing import Any, ClassVar

import numpy as np

from tierod.diagnosis.trouble_codes import TroubleCode


class CodeStatus(IntFlag):
    """Status bits of a trouble code. Source: ISO 14229-1:2020, annex D.2, DTC status bits."""

    TEST_FAILED = 0x01  # The latest completed test failed
    FAILED_THIS_CYCLE = 0x02  # A test failed in this operation cycle
    PENDING = 0x04  # A test failed in this or the last operation cycle in which it was completed
    CONFIRMED = 0x08  # The test failed in the cycles required for confirmation, and the code has not aged since
    NOT_COMPLETED_SINCE_CLEAR = 0x10  # No test was completed since the memory was cleared
    FAILED_SINCE_CLEAR = 0x20  # A test failed since the memory was cleared
    NOT_COMPLETED_THIS_CYCLE = 0x40  # No test was completed in this operation cycle
    WARNING_REQUESTED = 0x80  # The warning lamp is requested

    @property
    def words(self) -> tuple[str, ...]:
        """Names of the bits that are set."""
        return tuple((bit.name or "").lower().replace("_", " ") for bit in CodeStatus if bit in self)


# Status of a code that has never been tested
CLEARED = CodeStatus.NOT_COMPLETED_SINCE_CLEAR | CodeStatus.NOT_COMPLETED_THIS_CYCLE


def after_test(status: CodeStatus, failed: bool) -> CodeStatus:
    """Status after a completed test; confirmation and lamp request are decided elsewhere."""
    status &= ~(CodeStatus.NOT_COMPLETED_SINCE_CLEAR | CodeStatus.NOT_COMPLETED_THIS_CYCLE)
    if not failed:
        return status & ~CodeStatus.TEST_FAILED
    return (
        status
        | CodeStatus.TEST_FAILED
        | CodeStatus.FAILED_THIS_CYCLE
        | CodeStatus.PENDING
        | CodeStatus.FAILED_SINCE_CLEAR
    )


def passed_this_cycle(status: CodeStatus) -> bool:
    """Whether a test was completed in this operation cycle and none failed."""
    return not status & (CodeStatus.NOT_COMPLETED_THIS_CYCLE | CodeStatus.FAILED_THIS_CYCLE)


def at_cycle_end(status: CodeStatus) -> CodeStatus:
    """Status at the end of an operation cycle: the pending bit is reset if the cycle passed."""
    return status & ~CodeStatus.PENDING if passed_this_cycle(status) else status


def at_cycle_start(status: CodeStatus) -> CodeStatus:
    """Status at the beginning of an operation cycle: no test completed yet."""
    return (status | CodeStatus.NOT_COMPLETED_THIS_CYCLE) & ~CodeStatus.FAILED_THIS_CYCLE


_CHECKED = {"strict": True, "extra": "forbid", "allow_inf_nan": False}  # How pydantic checks the content of a file


@dataclass(frozen=True)
class FreezeFrame:
    """Signals around the instant of a failed test."""

    __pydantic_config__: ClassVar[dict[str, object]] = _CHECKED

    cycle: int  # number of the operation cycle
    date: str  # beginning of the cycle, ISO 8601
    instant: float  # time of the failure in the recording [s]
    time: tuple[float, ...]  # times of the values relative to the instant [s]
    # values by signal, one per time, in SI units; None where nothing was measured
    values: Mapping[str, tuple[float | None, ...]]

    def at_instant(self) -> dict[str, float | None]:
        """Latest measured value of each signal up to the instant."""
        found: dict[str, float | None] = {}
        # The small tolerance covers rounding errors of the times.
        for name, values in self.values.items():
            until = [value for at, value in zip(self.time, values, strict=True) if at <= 1e-9 and value is not None]
            found[name] = until[-1] if until else None
        return found


@dataclass(frozen=True)
class Entry:
    """Entry of one trouble code."""

    __pydantic_config__: ClassVar[dict[str, object]] = _CHECKED

    status: CodeStatus = CLEARED
    counter: int = 0
    verdict: int = 0  # present verdict: 1 failed, -1 passed, 0 none yet
    occurrences: int = 0  # number of changes to failed since the memory was cleared
    failed_cycles: int = 0  # number of consecutive failed cycles, up to confirmation
    passed_cycles: int = 0  # number of consecutive passed cycles, for healing and then for aging
    healed: bool = False  # whether the lamp request has been withdrawn and aging has begun
    consequence_of: str = ""  # name of the code that caused the latest failure, until a test passes; "" for none
    first: FreezeFrame | None = None
    last: FreezeFrame | None = None

    @property
    def stored(self) -> bool:
        """Whether the code occupies a place in the memory: pending or confirmed, and not displaced."""
        return bool(self.status & (CodeStatus.PENDING | CodeStatus.CONFIRMED))

    def with_(self, **changes: Any) -> Entry:
        """A copy of the entry with some fields replaced."""
        return dataclasses.replace(self, **changes)

    def document(self) -> dict[str, Any]:
        """Entry as content of the JSON file."""
        content = dataclasses.asdict(self)
        content["status"] = int(self.status)
        return content

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Entry:
        """Entry from the content of the JSON file; a ValueError where anything is missing, unknown or out of range."""
        if set(content) != {each.name for each in dataclasses.fields(cls)}:
            raise ValueError("a field is missing or unknown")
        entry: Entry = _reader().validate_json(json.dumps(content))
        counts = (entry.occurrences, entry.failed_cycles, entry.passed_cycles)
        if not (
            -128 <= entry.counter <= 127 and -1 <= entry.verdict <= 1 and all(0 <= each < 2**31 for each in counts)
        ):
            raise ValueError("a count is out of its range")
        for frame in (entry.first, entry.last):
            if frame is not None and any(len(each) != len(frame.time) for each in frame.values.values()):
                raise ValueError("a freeze frame is incomplete")
        return entry


@cache
def _reader() -> Any:
    from pydantic import TypeAdapter

    return TypeAdapter(Entry)


def failed(entry: Entry, code: TroubleCode) -> Entry:
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
    """Entry after it was displaced by another one: no longer stored, but its present test result remains."""
    gone = CodeStatus.PENDING | CodeStatus.CONFIRMED | CodeStatus.WARNING_REQUESTED
    return Entry(status=entry.status & ~gone, counter=entry.counter, verdict=entry.verdict)


def begun(entry: Entry) -> Entry:
    """Entry at the beginning of an operation cycle: tests start again, earlier results remain."""
    return entry.with_(status=at_cycle_start(entry.status), counter=0, verdict=0)


def ended(entry: Entry, code: TroubleCode) -> Entry:
    """Entry at the end of an operation cycle: passed cycles first withdraw the lamp request, then delete the code.

    A code that never requested the lamp ages from its first passed cycle on. A cycle in which the test failed as a
    consequence of another code does not count as passed.
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


BEFORE, AFTER = 2.0, 1.0  # Time before and after the failure that a freeze frame covers [s]
MOST = 61  # Largest number of values per signal in a freeze frame


class Window:
    """Recent samples of the signals for freeze frames."""

    def __init__(self) -> None:
        self.time = np.zeros(0)
        self.values: dict[str, np.ndarray] = {}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """Append later samples; a signal missing in a piece is NaN there."""
        old, new = len(self.time), len(time)
        self.time = np.concatenate([self.time, time])
        for name in {**self.values, **signals}:
            before = self.values.get(name, np.full(old, np.nan))
            self.values[name] = np.concatenate([before, signals.get(name, np.full(new, np.nan))])

    def forget(self, until: float) -> None:
        """Remove samples before a time [s]."""
        first = int(np.searchsorted(self.time, until))
        self.time = self.time[first:]
        self.values = {name: values[first:] for name, values in self.values.items()}

    def frame(self, cycle: int, date: str, instant: float) -> FreezeFrame:
        """Freeze frame of the signals around an instant [s], thinned such that the sample of the instant is kept."""
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
