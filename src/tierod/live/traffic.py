"""Load of a bus: frames and bits of the last second, relative to its bit rate."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from tierod.io.readers.frames import EXTENDED
from tierod.live.frame import Frame

USUAL: Annotated[int, "bit/s"] = 500_000
"""Bit rate of most vehicle buses, assumed if none was given."""

STANDARD, LONG = 47, 67
"""Bits of a frame beside its payload, including the interframe space, with 11-bit and 29-bit identifiers."""

STUFFED = 1.1
"""Average factor of bit stuffing: the sender inserts a bit after five equal ones, a fifth more at most."""

SPAN: Annotated[float, "s"] = 1.0
"""Time over which frames and bits are counted."""


@dataclass(frozen=True)
class Load:
    """Load of one bus.

    Args:
        frames: frames per second
        load: bits per second as a share of the bit rate
        rate: the bit rate in words
    """

    frames: Annotated[float, "1/s"]
    load: float
    rate: str


class Traffic:
    """Counts the frames and bits on the buses.

    Args:
        bitrate: bit rate of the buses [bit/s]; USUAL where None
    """

    def __init__(self, bitrate: int | None = None):
        self._bitrate = bitrate
        self._seen: deque[tuple[float, Mapping[int, tuple[int, float]]]] = deque()

    def add(self, frames: Sequence[Frame], now: float) -> None:
        """Add frames received at time `now` of the computer's clock [s]; CAN FD counts by its arbitration bit rate."""
        found: dict[int, tuple[int, float]] = {}
        for frame in frames:
            count, bits = found.get(frame.bus, (0, 0.0))
            own = STUFFED * (8 * len(frame.data) + (LONG if frame.identifier & EXTENDED else STANDARD))
            found[frame.bus] = count + 1, bits + own
        self._seen.append((now, found))
        while self._seen and self._seen[0][0] <= now - SPAN:
            self._seen.popleft()

    def loads(self) -> dict[int, Load]:
        """Load of every bus over the last second, by bus number."""
        rate = self._bitrate or USUAL
        words = f"{rate / 1000:.0f} kbit/s" + ("" if self._bitrate else " (assumed)")
        sums: dict[int, tuple[int, float]] = {}
        for _, found in self._seen:
            for bus, (count, bits) in found.items():
                before = sums.get(bus, (0, 0.0))
                sums[bus] = before[0] + count, before[1] + bits
        return {bus: Load(count / SPAN, bits / SPAN / rate, words) for bus, (count, bits) in sorted(sums.items())}
