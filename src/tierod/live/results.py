"""Results of the monitors as CAN frames, with a DBC that describes them for other devices on the bus."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tierod.core.errors import InputError
from tierod.core.files import write_text
from tierod.core.statement import STATUSES
from tierod.live.buses import Address, open_bus
from tierod.live.judge import Shown

if TYPE_CHECKING:
    import can
    from cantools.database.can import Message

FIRST = 0x6E0
"""Default identifier of the first message; the others follow consecutively."""

UNKNOWN = 255
"""Code of a status that is not in `STATUSES`."""


@dataclass(frozen=True)
class Layout:
    """Layout of one message: status of a monitor, start of the status, and first estimate with a standard deviation.

    Args:
        monitor: name of the monitor
        identifier: identifier of the message
        estimate: name of the estimate; "" for none
        unit: unit of the estimate
    """

    monitor: str
    identifier: int
    estimate: str = ""
    unit: str = ""

    @property
    def name(self) -> str:
        """Name of the message in the DBC."""
        return "Tierod_" + re.sub(r"\W", "_", self.monitor)


def layouts(monitors: Sequence[tuple[str, Mapping[str, str]]], first: int = FIRST) -> tuple[Layout, ...]:
    """Message layouts of some monitors.

    Args:
        monitors: name of each monitor, and units of its estimates by name
        first: identifier of the first message

    Raises:
        InputError: the identifiers exceed 11 bits
    """
    if not 0 <= first <= 0x7FF + 1 - len(monitors):
        raise InputError(f"{len(monitors)} messages from 0x{first:X} on do not fit into 11 bits; begin at 0x6E0")
    found = []
    for place, (monitor, units) in enumerate(monitors):
        estimate = next((name for name in units if f"{name}_standard_deviation" in units), "")
        found.append(Layout(monitor, first + place, estimate, units.get(estimate, "")))
    return tuple(found)


def refuse_clash(database: Iterable[Message], monitors: int, first: int = FIRST) -> None:
    """Refuse identifiers of results that messages of the vehicle already use.

    Args:
        database: messages of all databases
        monitors: number of monitors that send
        first: identifier of the first message

    Raises:
        InputError: a message of the databases uses one of them, or they exceed 11 bits
    """
    own = {each.identifier for each in layouts([("", {})] * monitors, first)}
    taken = {each.frame_id: each.name for each in database if not each.is_extended_frame}
    clash = sorted(own & taken.keys())
    if not clash:
        return
    free = next((at for at in range(0x7FF + 1 - monitors, 0, -1) if not {*range(at, at + monitors)} & taken.keys()), 0)
    remedy = f"give --results-id 0x{free:X}" if free else "no place is free: leave --send out"
    raise InputError(
        f"results are sent from 0x{first:X} on, and the databases have {taken[clash[0]]} at 0x{clash[0]:X}; {remedy}"
    )


def database(messages: Sequence[Layout]) -> str:
    """Text of the DBC that describes the messages."""
    parts = ['VERSION ""', "NS_ :", "BS_:", "BU_: tierod", ""]
    values = []
    for each in messages:
        parts.append(f"BO_ {each.identifier} {each.name}: 8 tierod")
        parts.append(f' SG_ status : 0|8@1+ (1,0) [0|{len(STATUSES) - 1}] "" Vector__XXX')
        parts.append(' SG_ since : 8|24@1+ (0.01,0) [0|167772] "s" Vector__XXX')
        if each.estimate:
            parts.append(f' SG_ {each.estimate} : 32|32@1- (1,0) [0|0] "{each.unit}" Vector__XXX')
            values.append(f"SIG_VALTYPE_ {each.identifier} {each.estimate} : 1;")
        parts.append("")
        names = " ".join(f'{code} "{status.value}"' for code, status in enumerate(STATUSES))
        values.append(f'VAL_ {each.identifier} status {names} {UNKNOWN} "unknown" ;')
    return "\n".join([*parts, *values, ""])


def payload(layout: Layout, shown: Shown) -> bytes:
    """The eight payload bytes of a message.

    Args:
        layout: layout of the message
        shown: displayed state of the monitor
    """
    code = STATUSES.index(shown.status) if shown.status in STATUSES else UNKNOWN
    since = min(max(round(shown.since / 0.01), 0), (1 << 24) - 1)
    value = shown.values.get(layout.estimate, math.nan) if layout.estimate else 0.0
    return struct.pack("<B", code) + since.to_bytes(3, "little") + struct.pack("<f", value)


class Sender:
    """Sends the results to a bus periodically.

    Args:
        address: address of the bus
        path: path of the DBC, written again whenever the messages change
        first: identifier of the first message
        every: period of a message

    Raises:
        InputError: the bus cannot be opened
    """

    def __init__(self, address: Address, path: Path, first: int = FIRST, every: Annotated[float, "s"] = 0.1):
        self.path, self.every, self.failed, self.sent = path, every, 0, 0
        self._first = first
        self._bus: can.BusABC = open_bus(address)
        self._layouts: tuple[Layout, ...] = ()
        self.identifiers: set[int] = set()
        self._last = -math.inf

    def send(self, shown: Sequence[Shown], now: float) -> None:
        """Send the states of the monitors if the period has elapsed.

        Args:
            shown: displayed states of all monitors
            now: time of the computer's monotonic clock [s]

        Raises:
            OutputError: the DBC cannot be written
        """
        import can

        if now - self._last < self.every:
            return
        self._last = now
        made = layouts([(each.monitor, each.units) for each in shown], self._first)
        if made != self._layouts:
            write_text(self.path, database(made))
            self._layouts = made
            self.identifiers.update(layout.identifier for layout in made)
        for layout, each in zip(made, shown, strict=True):
            message = can.Message(
                arbitration_id=layout.identifier, data=payload(layout, each), is_extended_id=False, check=False
            )
            try:
                self._bus.send(message)
                self.sent += 1
            except can.CanError:
                self.failed += 1

    def close(self) -> None:
        """Close the bus."""
        self._bus.shutdown()
