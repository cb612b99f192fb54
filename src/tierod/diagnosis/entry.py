"""What a fault memory keeps of one trouble code."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tierod.diagnosis.status import CLEARED, CodeStatus


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
    """What is known of one trouble code.

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
        """As it stands in a file."""
        content = dataclasses.asdict(self)
        content["status"] = int(self.status)
        return content

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Entry:
        """From what stands in a file.

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


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_finite(value: Any) -> bool:
    """Whether it is a number that a float holds: JSON knows neither a largest number nor, in Python, NaN."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def _frame(content: Any) -> FreezeFrame | None:
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
