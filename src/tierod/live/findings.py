"""Entries of the MCAP log of a drive: samples as they are judged, and events in words."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from tierod.core.errors import OutputError
from tierod.live.engine import Engine
from tierod.live.events import Hub
from tierod.live.judge import Judge
from tierod.live.mcap_log import LEVELS, McapLog

SAID = ("verdict", "problem", "silence", "bus", "mark", "end")
"""Kinds of events that become log entries."""


class Findings:
    """Feeds a log until it is closed; a write error ends the log, but not the drive.

    Args:
        log: the opened log
        engine: engine of the drive
        hub: source of the events
    """

    def __init__(self, log: McapLog, engine: Engine, hub: Hub):
        self._log: McapLog | None = log
        self._engine, self._hub = engine, hub
        engine.tap = lambda channels: self._guarded(lambda: log.signals(channels))
        for judge in engine.judges:
            judge.tap(partial(self._estimates, judge))
        hub.add(self.event)

    def _estimates(self, judge: Judge, time: np.ndarray, shown: Mapping[str, np.ndarray]) -> None:
        log = self._log
        if log is not None:
            self._guarded(lambda: log.estimates(judge.name, judge.units, time, shown))

    def event(self, text: str) -> None:
        """Log an event of the hub."""
        event = json.loads(text)
        log, kind = self._log, event["event"]
        if log is None or kind not in SAID:
            return
        time = event.get("time") or max(self._engine.clock.latest, 0.0)
        level = LEVELS.get(event.get("colour", ""), 3 if kind == "problem" else 2)
        self._guarded(lambda: log.finding(time, level, event.get("monitor", kind), _words(event)))

    def _guarded(self, work: Callable[[], None]) -> None:
        # Samples come from the judging thread, events from any: access to the log is serialized.
        with self._hub.lock:
            if self._log is None:
                return
            try:
                work()
            except OutputError as error:
                self._log = None
                self._hub.say("problem", {"text": f"{error}; monitoring goes on without it"})

    def close(self) -> None:
        """Finish the log.

        Raises:
            OutputError: the index of the log cannot be written
        """
        log, self._log = self._log, None
        self._hub.remove(self.event)
        if log is not None:
            log.finish()


def _words(event: Mapping[str, Any]) -> str:
    if event["event"] == "verdict":
        reason = event.get("reason", "")
        return f"{event['monitor']}: {event['status']}" + (f", {reason}" if reason else "")
    if event["event"] == "end":
        return "; ".join(map(str, event.get("headlines", {}).values())) or "the drive has ended"
    return str(event.get("text", event["event"]))
