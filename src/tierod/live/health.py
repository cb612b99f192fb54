"""Health of a live session itself: load of computer and buses, and notices of the buses."""

from __future__ import annotations

import queue
import time
from collections import Counter
from dataclasses import dataclass, field

from tierod.live.buses import Inbox
from tierod.live.events import Hub
from tierod.live.frame import Frame, Notice
from tierod.live.traffic import Traffic

MOST = 10_000
"""Largest number of frames processed at once; the rest waits for the next one."""

SAID = (1, 10, 100, 1000)
"""Numbers of error frames at which a notice is reported."""


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
    """Frames waiting in the inbox; notices of buses are counted and reported.

    Args:
        inbox: queue that the receivers fill
        health: counter of the notices
        hub: receives the notices
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
