"""Health of a live session: load of computer and buses, notices of the buses, and the state for display."""

from __future__ import annotations

import queue
import time
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

from tierod.io.readers.frames import EXTENDED
from tierod.live.buses import Inbox
from tierod.live.engine import Engine
from tierod.live.events import Hub
from tierod.live.frame import Frame, Notice
from tierod.live.judge import Shown

MOST = 10_000
"""Largest number of frames processed at once; the rest waits for the next one."""

SAID = (1, 10, 100, 1000)
"""Numbers of error frames at which a notice is reported."""

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
        load: bits per second as a share of the bit rate
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


@dataclass
class Health:
    """Notices by kind, traffic on the buses, and load of this process."""

    notices: Counter[str] = field(default_factory=Counter)
    traffic: Traffic = field(default_factory=Traffic)
    _used: tuple[float, float] = (0.0, 0.0)

    def load(self) -> float:
        """Share of one core used by this process since the previous call; 0 at the first call."""
        (then, before), now = self._used, (time.monotonic(), time.process_time())
        self._used = now
        return max((now[1] - before) / (now[0] - then), 0.0) if now[0] > then > 0.0 else 0.0


def received(inbox: Inbox, health: Health, hub: Hub) -> list[Frame]:
    """Frames waiting in the inbox; notices of buses are counted and reported."""
    frames: list[Frame] = []
    take = inbox.get_nowait
    for _ in range(MOST):
        try:
            each = take()
        except queue.Empty:
            break
        if isinstance(each, Notice):
            health.notices[each.what] += 1
            if each.what != "error frame" or health.notices[each.what] in SAID:
                hub.say("bus", {"bus": each.bus, "what": each.what, "text": each.text})
        else:
            frames.append(each)
    return frames


def shown_state(engine: Engine, health: Health) -> dict[str, Any]:
    """Current state of the drive."""
    return {
        "time": engine.clock.latest,
        "frames": engine.tally.frames,
        "lost": engine.gaps.lost,
        "late": engine.clock.late,
        "too_late": engine.tally.too_late,
        "doubled": engine.clock.doubled,
        "clock_jumps": engine.clock.jumps,
        "bus": dict(health.notices),
        "buses": {
            f"CAN{bus}": {"frames_per_s": each.frames, "load": round(each.load, 3), "of": each.rate}
            for bus, each in health.traffic.loads().items()
        },
        "processor": round(health.load(), 3),
        "missing": list(engine.missing),
        "ages": {name: round(age, 3) for name, age in engine.ages.items()},
        "monitors": [_monitor(each, engine.delay) for each in engine.shown()],
    }


def _monitor(each: Shown, delay: float) -> dict[str, Any]:
    return {
        "monitor": each.monitor,
        **each.status.document(),
        "since": each.since,
        "reason": each.reason,
        "delay": delay,
        "enabled": each.enabled,
        "values": dict(each.values),
        "units": dict(each.units),
    }
