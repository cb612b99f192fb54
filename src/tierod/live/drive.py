"""A live session: buses, one drive after the other, events, checkpoints, and a clean end."""

from __future__ import annotations

import queue
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tierod.core.errors import TierodError
from tierod.core.files import write_text
from tierod.io.readers.channel_map import ChannelMap
from tierod.live import checkpoint
from tierod.live.buses import Inbox, Receiver
from tierod.live.closing import page, remembered
from tierod.live.engine import PACE, Engine, Pace
from tierod.live.events import Hub
from tierod.live.findings import Findings
from tierod.live.frame import Frame, Notice
from tierod.live.judge import Plan
from tierod.live.log import FrameLog, is_unfinished
from tierod.live.mcap_log import McapLog
from tierod.live.receiving import ProcessReceiver
from tierod.monitors.harness.baseline import keep_first

if TYPE_CHECKING:
    from cantools.database.can import Message

    from tierod.core.findings import Diagnosis
    from tierod.report.html import Origin

TICK = 0.01
"""Time between two looks at what has come [s]."""

STATED = 1.0
"""Time between two events with the state of the drive [s]."""

SILENT = 5.0
"""Time without a frame after which the bus is called silent [s]."""

_SEVERITY = (0, 2, 1)
"""Exit codes, the worst last: a fault is worse than what could not be judged."""


@dataclass(frozen=True)
class Outputs:
    """Where the results of a session go.

    Args:
        log: MF4 file of all frames; the second drive gets "-2" behind its name
        report: HTML page at the end of a drive
        checkpoint: file of the states
        every: time between two checkpoints
        silence: time without a frame after which the drive has ended; infinite for one drive alone
        ignition: column of the databases ("Message.Signal") whose zero ends the drive; "" without
        width: bytes of a payload in the log
        mcap: MCAP file of signals, estimates and findings
    """

    log: Path | None = None
    report: Path | None = None
    checkpoint: Path | None = None
    every: Annotated[float, "s"] = 5.0
    silence: Annotated[float, "s"] = 30.0
    ignition: str = ""
    width: int = 8
    mcap: Path | None = None


@dataclass
class Health:
    """How the session itself does: ticks, how late they came [s], the worst of late, notices by kind."""

    ticks: int = 0
    late: list[float] = field(default_factory=list)
    notices: Counter[str] = field(default_factory=Counter)


class Drive:
    """Runs until `ended` is set.

    Args:
        receivers: of all buses, not started
        inbox: that they fill
        database: messages of all databases
        channel_map: of the vehicle
        monitors: their names
        plan: how they run
        outputs: where results go
        hub: takes events
        pace: when what is done
        origin: of the report; None writes none

    `looking` is called after every tick with the computer's clock [s].
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
        self.worst = 0
        self.marks: list[float] = []
        self.report_words: Callable[[Path], list[str]] = lambda path: ["diagnose", str(path)]
        self.looking: list[Callable[[float], None]] = []
        self._origin = origin
        self._made: Callable[[], Engine] = lambda: Engine(
            database, channel_map, monitors, plan, hub.say, pace, ignition=outputs.ignition
        )
        self.engine = self._made()
        self._came = self._checked = self._begun = self._stated = time.monotonic()
        self._said: set[str] = set()
        self._running = False
        self._log: Path | None = None
        self._mcap: Findings | None = None
        self._waiting = self._checkpoint()

    def _checkpoint(self) -> Mapping[str, tuple[str, Any]]:
        path = self.outputs.checkpoint
        if path is None or not path.exists():
            return {}
        try:
            found = checkpoint.taken_up(path, self.plan.vehicle)
        except TierodError as error:
            self.hub.say("checkpoint", {"text": str(error)})
            return {}
        return found

    def run(self) -> int:
        """Receive and judge until the end.

        Returns:
            exit code of the worst verdict: 0 healthy, 1 fault, 2 could not judge
        """
        for receiver in self.receivers:
            receiver.start()
        due = time.monotonic()
        try:
            while not self.ended:
                due = max(due + TICK, time.monotonic() - 20 * TICK)
                pause = due - time.monotonic()
                if pause > 0.0:
                    time.sleep(pause)
                    self.health.late.append(time.monotonic() - due)
                    del self.health.late[:-3000]
                self.tick(time.monotonic(), time.time())
                for look in self.looking:
                    look(time.monotonic())
        finally:
            for receiver in self.receivers:
                receiver.end()
            self.tick(time.monotonic(), time.time())
            self.close()
        return self.worst if self.drives else 2

    def tick(self, now: float, calendar: float) -> None:
        """Take what has come, judge where a stretch is complete, write what is due.

        Args:
            now: by the computer's clock [s]
            calendar: time of the computer [s]
        """
        self.health.ticks += 1
        frames = self._received()
        if frames:
            self._came = now
            if not self._running:
                self._begin(frames[0], now, calendar)
            self.engine.take(frames, now, calendar)
        elif self._running and now - self._came > self.outputs.silence:
            self.close()
        elif now - self._came > SILENT:
            self.once("silent", self._silent_sentence())
        if self._running and self.engine.due and not self.paused:
            self._judge()
        if self._running and now - self._stated >= STATED:
            self._stated = now
            self.hub.say("state", self.state())
        if self._running and self.outputs.checkpoint is not None and now - self._checked >= self.outputs.every:
            self._checked = now
            self._store()

    def _silent_sentence(self) -> str:
        if self.health.notices["error frame"] > 10 and not self._running:
            return "error frames alone come: the bit rate is wrong; give that of the bus with --bitrate"
        return f"no frame came for {SILENT:.0f} s; switch the ignition on, and check channel and bit rate"

    def _received(self) -> list[Frame]:
        frames: list[Frame] = []
        take = self.inbox.get_nowait
        for _ in range(10_000):
            try:
                each = take()
            except queue.Empty:
                break
            if isinstance(each, Notice):
                self.health.notices[each.what] += 1
                if each.what != "error frame" or self.health.notices[each.what] in (1, 10, 100, 1000):
                    self.hub.say("bus", {"bus": each.bus, "what": each.what, "text": each.text})
            else:
                frames.append(each)
        return frames

    def once(self, key: str, text: str) -> None:
        """Say a problem, once in a drive.

        Args:
            key: of the problem
            text: a sentence with its remedy
        """
        if key not in self._said:
            self._said.add(key)
            self.hub.say("problem", {"text": text})

    def _begin(self, first: Frame, now: float, calendar: float) -> None:
        self._running, self._begun, self._checked = True, now, now
        self._said.clear()
        self.engine.clock.begin(first, now, calendar)
        path = self._log = self._free(self.outputs.log)
        if path is not None:
            self._open_log(path)
        if self.outputs.mcap is not None:
            self._guarded(lambda: self._open_mcap(self._free(self.outputs.mcap)))
        self.hub.say("begin", {"origin": self.engine.clock.origin, "log": str(path) if path else None})

    def _open_log(self, path: Path) -> None:
        vehicle = self.plan.vehicle.name
        try:
            self.engine.log = FrameLog(path, self.engine.clock.origin, self.outputs.width, f"tierod live, {vehicle}")
        except TierodError as error:
            self.hub.say("problem", {"text": f"{error}; monitoring goes on without a log"})

    def _open_mcap(self, path: Path | None) -> None:
        assert path is not None
        self._mcap = Findings(McapLog(path, self.engine.clock.origin), self.engine, self.hub)

    def _log_path(self) -> Path | None:
        """Where this drive is logged: the next name that is free, since what is there may be all that a kill left."""
        return self._log

    def _free(self, path: Path | None) -> Path | None:
        if path is None:
            return None
        number = self.drives
        while (found := _numbered(path, number)) is not None and found.exists():
            number += 1
        if number > self.drives:
            before = _numbered(path, number - 1)
            assert before is not None
            text = f"{before} is there already; this drive is {found}"
            if is_unfinished(before) and self.plan.memory is not None:
                words = f"tierod diagnose {before} --vehicle {self.plan.vehicle.name} --memory {self.plan.memory}"
                text += f". Its drive was cut off and is not in the fault memory: {words} takes it there"
            self.hub.say("problem", {"text": text})
        return found

    def _judge(self) -> None:
        self.engine.judge()
        for judge in self.engine.judges:
            waiting = self._waiting.get(judge.name)
            if waiting is not None and judge.run is not None:
                digest, memory = waiting
                self._waiting = {name: each for name, each in self._waiting.items() if name != judge.name}
                if checkpoint.fits(judge, digest, memory):
                    judge.go_on(memory)
                    self.hub.say("checkpoint", {"monitor": judge.name, "text": "goes on from the checkpoint"})
                else:
                    text = "the checkpoint is of another calibration; it begins anew"
                    self.hub.say("checkpoint", {"monitor": judge.name, "text": text})
        for name in self.engine.missing:
            self.once(f"missing {name}", f"{name} does not come any more; what needs it is not judged")
        known = self.engine.decoder.known
        if known is None:
            self.once("unknown", "no frame that came is in the databases; give the DBC of this vehicle and bus")
        if self.engine.ignition_off:
            self.close()

    def state(self) -> dict[str, Any]:
        """What is shown of the drive now."""
        engine = self.engine
        return {
            "time": engine.clock.latest,
            "frames": engine.tally.frames,
            "lost": engine.gaps.lost,
            "late": engine.clock.late,
            "too_late": engine.tally.too_late,
            "doubled": engine.clock.doubled,
            "clock_jumps": engine.clock.jumps,
            "bus": dict(self.health.notices),
            "ages": {name: round(age, 3) for name, age in engine.ages.items()},
            "monitors": [
                {
                    "monitor": each.monitor,
                    "status": str(each.status),
                    "since": each.since,
                    "reason": each.reason,
                    "enabled": each.enabled,
                    "values": dict(each.values),
                    "units": dict(each.units),
                }
                for each in engine.shown()
            ],
        }

    def mark(self, text: str = "mark") -> None:
        """Note an event of the driver."""
        self.marks.append(self.engine.clock.latest)
        self.hub.say("mark", {"time": self.engine.clock.latest, "text": text})

    def _store(self) -> None:
        assert self.outputs.checkpoint is not None
        try:
            checkpoint.stored(self.engine.judges, self.plan.vehicle, self.outputs.checkpoint)
        except TierodError as error:
            self.once("checkpoint", str(error))

    def close(self) -> None:
        """End the drive: judge the rest, finish the log, write memory, report, checkpoint and baselines."""
        if not self._running:
            return
        self._running = False
        if self.outputs.checkpoint is not None:
            self._store()
        engine, finished = self.engine, []
        for judge, diagnosis, feed in engine.finish():
            finished.append((judge, diagnosis, feed))
            self.worst = max(self.worst, diagnosis.findings[0].status.exit_code, key=_SEVERITY.index)
        self._guarded(lambda: self._remember([(a, b, c) for a, b, c in finished if c is not None]))
        self._guarded(lambda: self._baselines([(judge, diagnosis) for judge, diagnosis, _ in finished]))
        diagnoses = {judge.name: diagnosis for judge, diagnosis, _ in finished}
        self._guarded(lambda: self._report(diagnoses))
        verdicts = {name: str(each.findings[0].status) for name, each in diagnoses.items()}
        headlines = {name: each.findings[0].headline for name, each in diagnoses.items()}
        missed = {judge.name: judge.reason for judge in engine.judges if judge.name not in diagnoses}
        content = {"time": engine.clock.latest, "frames": engine.tally.frames, "lost": engine.gaps.lost}
        self.hub.say("end", content | {"verdicts": verdicts, "headlines": headlines, "not_run": missed})
        if self._mcap is not None:
            self._guarded(self._mcap.close)
            self._mcap = None
        self.drives += 1
        self.engine = self._made()

    def _guarded(self, work: Callable[[], None]) -> None:
        try:
            work()
        except TierodError as error:
            self.hub.say("problem", {"text": str(error)})

    def _remember(self, finished: list[Any]) -> None:
        if finished:
            self.hub.say("memory", {"text": remembered(finished)})

    def _baselines(self, finished: list[Any]) -> None:
        import dataclasses

        for judge, diagnosis in finished:
            path, learnt = judge.baseline_path, judge.run.learnt
            if path is not None and learnt is not None and not path.exists():
                text = keep_first(dataclasses.replace(learnt, learnt=diagnosis.created), path)
                self.hub.say("baseline", {"monitor": judge.name, "text": text})

    def _report(self, diagnoses: Mapping[str, Diagnosis]) -> None:
        path = _numbered(self.outputs.report, self.drives)
        if path is None or self._origin is None or not diagnoses:
            return
        from tierod.report import several

        log = self._log_path() or Path("live")
        judged = page(self.engine.judges, diagnoses, log, self.plan.vehicle.name)
        write_text(path, several.render([judged], self._origin()))
        self.hub.say("report", {"path": str(path)})


def _numbered(path: Path | None, drives: int) -> Path | None:
    """The path of this drive: as given for the first, with a number behind its name for the others."""
    return path if path is None or not drives else path.with_name(f"{path.stem}-{drives + 1}{path.suffix}")
