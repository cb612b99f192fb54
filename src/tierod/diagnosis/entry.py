"""What a fault memory keeps of one trouble code."""

from __future__ import annotations

import dataclasses
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
        if not (isinstance(content["status"], int) and 0 <= content["status"] <= 255):
            raise ValueError(f"a status is {content['status']}, not a byte")
        frames = {name: _frame(content[name]) for name in ("first", "last")}
        return cls(**{**content, "status": CodeStatus(content["status"]), **frames})


def _frame(content: Any) -> FreezeFrame | None:
    if content is None:
        return None
    if not isinstance(content, dict) or set(content) != {each.name for each in dataclasses.fields(FreezeFrame)}:
        raise ValueError("a freeze frame is not whole")
    values = {name: tuple(each) for name, each in content["values"].items()}
    return FreezeFrame(**{**content, "time": tuple(content["time"]), "values": values})
