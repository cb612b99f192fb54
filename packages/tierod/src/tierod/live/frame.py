"""Frame of a live bus, and notices of a receiver about its bus."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from tierod.io.readers.frames import Frames


class Frame(NamedTuple):
    """Frame as a bus delivered it.

    Args:
        time: time stamp of the bus; after `DriveClock.placed` the time in the drive
        identifier: identifier, with the bit EXTENDED set for 29 bits
        bus: number of the bus, from 1
    """

    time: Annotated[float, "s"]
    identifier: int
    bus: int
    data: bytes


class Notice(NamedTuple):
    """Event on a bus: "lost", "back", "error frame" or "ended".

    Args:
        bus: number of the bus, from 1
    """

    bus: int
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
