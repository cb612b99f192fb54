"""State of a live session for display, sent every second as an event."""

from __future__ import annotations

from typing import Any

from tierod.live.engine import Engine
from tierod.live.health import Health
from tierod.live.judge import Shown


def shown_state(engine: Engine, health: Health) -> dict[str, Any]:
    """Current state of the drive.

    Args:
        engine: engine of the drive
        health: health of the session
    """
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
