"""A live session: buses, one drive after another, events, and an orderly end."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from tierod.core.statuses import Status, worst
from tierod.io.readers.channel_map import ChannelMap
from tierod.live.buses import Inbox, Receiver
from tierod.live.engine import PACE, Engine, Judging, Pace
from tierod.live.events import Hub, Watching
from tierod.live.frame import Frame
from tierod.live.health import Health, received, shown_state
from tierod.live.judge import Plan
from tierod.live.outputs import Closing, Finished, Logs, Outputs, numbered
from tierod.live.receiving import ProcessReceiver

if TYPE_CHECKING:
    from cantools.database.can import Message

    from tierod.report.html import Origin

__all__ = ["Drive", "Health", "Outputs"]

TICK = 0.01
"""Pause of the main loop, in which received frames are logged and pieces are begun [s]."""

STATED = 1.0
"""Period of the events with the state of the drive [s]."""

SILENT = 5.0
"""Time without a frame after which the bus is reported as silent [s]."""


class Drive:
    """Runs a session until `ended` is set.

    Args:
        receivers: receivers of all buses, not yet started
        pace: periods and waiting times of the engine
        origin: provenance printed on the report; None writes no report

    The functions in `looking` are called after every tick with the computer's clock [s].
    """

    def __init__(
        self,
        receivers: Sequence[Receiver | ProcessReceiver],
        inbox: Inbox,
        database: Sequence[Message],
        channel_map: ChannelMap | None,
        monitors: Sequence[str],
        plan: Plan,
        outputs: Outputs,
        hub: Hub,
        pace: Pace = PACE,
        origin: Callable[[], Origin] | None = None,
    ):
        self.receivers, self.inbox, self.hub, self.outputs, self.plan = receivers, inbox, hub, outputs, plan
        self.health = Health()
        self.ended = False
        self.paused = False
        self.drives = 0
        self.statuses: list[Status] = []
        self.marks: list[float] = []
        self.looking: list[Callable[[float], None]] = []
        self._origin = origin
        self._made: Callable[[], Engine] = lambda: Engine(
            database, channel_map, monitors, plan, hub.say, pace, ignition=outputs.ignition
        )
        self.engine = self._made()
        self._came = self._stated = time.monotonic()
        self._watching = Watching(hub)
        self._running = False
        self.logs = Logs(outputs, plan, hub)
        self._judging = Judging(threaded=False)

    def run(self) -> int:
        """Receive and judge until the end.

        Returns:
            exit code of the worst verdict: 0 healthy, 1 fault, 2 could not judge or no drive
        """
        self._judging = Judging(threaded=True)
        for receiver in self.receivers:
            receiver.start()
        try:
            while not self.ended:
                time.sleep(TICK)
                self.tick(time.monotonic(), time.time())
                for look in self.looking:
                    look(time.monotonic())
        finally:
            for receiver in self.receivers:
                receiver.end()
            self.tick(time.monotonic(), time.time())
            self.close()
            self._judging.close()
        return self.exit_code

    @property
    def exit_code(self) -> int:
        return worst(self.statuses).exit_code

    def tick(self, now: float, calendar: float) -> None:
        """Process the frames received, judge where a piece is complete, and write what is due.

        Args:
            now: time of the computer's monotonic clock [s]
            calendar: calendar time of the computer [s]
        """
        frames = received(self.inbox, self.health, self.hub)
        self.health.traffic.add(frames, now)
        if frames:
            self._came = now
            if not self._running:
                self._begin(frames[0], now, calendar)
            self.engine.take(frames, now, calendar)
        if self._running and now - self._came > self.outputs.silence:
            self.close()
        elif now - self._came > SILENT:
            self.once("silent", self._silent_sentence())
        if self._running:
            self._judge()
        if self._running and now - self._stated >= STATED:
            self._stated = now
            self.hub.say("state", self.state())

    def _silent_sentence(self) -> str:
        if self.health.notices["error frame"] > 10 and not self._running:
            return "only error frames are received: the bit rate is wrong; give that of the bus with --bitrate"
        if self._running:
            return (
                f"no frame was received for {SILENT:.0f} s; the drive ends after {self.outputs.silence:.0f} s of "
                "silence"
            )
        return f"no frame was received for {SILENT:.0f} s; switch the ignition on, and check channel and bit rate"

    def once(self, key: str, text: str) -> None:
        """Report a problem once per drive."""
        self._watching.once(key, text)

    def _begin(self, first: Frame, now: float, calendar: float) -> None:
        self._running = True
        self._watching.begin()
        self.engine.clock.begin(first, now, calendar)
        self.logs.begin(self.engine, self.drives)
        path = self.logs.path
        self.hub.say("begin", {"origin": self.engine.clock.origin, "log": str(path) if path else None})

    def _judge(self) -> None:
        """Start judging a piece where one is complete, and process the result of one that was judged."""
        if self.engine.due and not self.paused and not self._judging.busy:
            self._judging.begin(self.engine)
        if self._judging.ended(self.engine):
            self._look()

    def _look(self) -> None:
        self._watching.missing(self.engine.missing, self.engine.clock.latest)
        known = self.engine.decoder.known
        if known is None:
            self.once("unknown", "no received frame is in the databases; give the DBC of this vehicle and bus")
        if self.engine.ignition_off:
            self.close()

    def state(self) -> dict[str, Any]:
        return shown_state(self.engine, self.health)

    def mark(self, text: str = "mark") -> None:
        """Record an event marked by the driver."""
        self.marks.append(self.engine.clock.latest)
        self.hub.say("mark", {"time": self.engine.clock.latest, "text": text})

    def close(self) -> None:
        """End the drive: judge the rest, finish the log, and write fault memory, baselines and report."""
        if not self._running:
            return
        self._running = False
        self._judging.ended(self.engine, wait=True)
        engine = self.engine
        finished = [Finished(*each) for each in engine.finish()]
        self.statuses.append(worst(each.diagnosis.status for each in finished))
        report = numbered(self.outputs.report, self.drives)
        Closing(self.plan, report, self.logs.path, self._origin, self.hub).write(engine, finished)
        self.drives += 1
        self.engine = self._made()
