"""A live session: buses, one drive after another, its health, events, and an orderly end."""

from __future__ import annotations

import queue
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

from tierod.core.statuses import Status, worst
from tierod.io.readers.channel_map import ChannelMap
from tierod.io.readers.frames import EXTENDED
from tierod.live.buses import Inbox, ProcessReceiver, Receiver
from tierod.live.clock import Frame, Notice
from tierod.live.engine import PACE, Engine, Judging, Pace
from tierod.live.events import Hub, Watching
from tierod.live.judge import Plan, Shown
from tierod.live.outputs import Closing, Finished, Logs, Outputs, numbered

if TYPE_CHECKING:
    from cantools.database.can import Message

    from tierod.report.html import Origin

MOST = 10_000  # Largest number of frames processed at once; the rest waits for the next one

SAID = (1, 10, 100, 1000)  # Numbers of error frames at which a notice is reported

USUAL: Annotated[int, "bit/s"] = 500_000  # Bit rate of most vehicle buses, assumed if none was given

STANDARD, LONG = 47, 67
"""Bits of a frame beside its payload, including the interframe space, with 11-bit and 29-bit identifiers."""

STUFFED = 1.1  # Average factor of bit stuffing: the sender inserts a bit after five equal ones, a fifth more at most

SPAN: Annotated[float, "s"] = 1.0  # Time over which frames and bits are counted


@dataclass(frozen=True)
class Load:
    """Load of one bus."""

    frames: Annotated[float, "1/s"]
    load: float  # bits per second as a share of the bit rate
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


TICK = 0.01  # Pause of the main loop, in which received frames are logged and pieces are begun [s]

STATED = 1.0  # Period of the events with the state of the drive [s]

SILENT = 5.0  # Time without a frame after which the bus is reported as silent [s]


class Drive:
    """Runs a session until `ended` is set.

    Args:
        receivers: receivers of all buses, not yet started
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
