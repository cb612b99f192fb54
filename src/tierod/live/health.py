"""Health of a live session itself: ticks, their lateness, load of computer and buses, and events of the buses."""

from __future__ import annotations

import queue
import time
from collections import Counter, deque
from dataclasses import dataclass, field

from tierod.live.buses import Inbox
from tierod.live.events import Hub
from tierod.live.frame import Frame, Notice
from tierod.live.traffic import Traffic

MOST = 10_000
"""Frames that are taken at a tick at the most; the others wait for the next one."""

SAID = (1, 10, 100, 1000)
"""Numbers of error frames that are said."""


@dataclass
class Health:
    """Health of the session itself: ticks, how late they came [s], the worst of late, notices by kind."""

    ticks: int = 0
    late: deque[float] = field(default_factory=lambda: deque(maxlen=3000))
    notices: Counter[str] = field(default_factory=Counter)
    traffic: Traffic = field(default_factory=Traffic)
    _used: tuple[float, float] = (0.0, 0.0)

    def load(self) -> float:
        """Share of one core that this process took since the last call."""
        (then, before), now = self._used, (time.monotonic(), time.process_time())
        self._used = now
        return max((now[1] - before) / (now[0] - then), 0.0) if now[0] > then > 0.0 else 0.0


def received(inbox: Inbox, health: Health, hub: Hub) -> list[Frame]:
    """The frames that have come; notices of buses are counted and reported.

    Args:
        inbox: that receivers fill
        health: counts notices
        hub: takes what is said
    """
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
