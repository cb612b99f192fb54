"""Results of a live session: the log of each drive, and at its end fault memory, page and baselines."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from tierod.core.errors import TierodError
from tierod.core.files import write_text
from tierod.core.findings import Diagnosis
from tierod.core.statuses import worst
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.live.engine import Engine
from tierod.live.events import Hub
from tierod.live.judge import Judge, Plan
from tierod.live.log import FrameLog, is_unfinished
from tierod.monitors.baseline import keep_first
from tierod.monitors.diagnose import Judged, NotRun

if TYPE_CHECKING:
    from tierod.monitors.memory import MemoryFeed
    from tierod.report.html import Origin

Results = tuple[np.ndarray, dict[str, np.ndarray], dict[str, np.ndarray]]


@dataclass(frozen=True)
class Outputs:
    """Paths of a session's results."""

    log: Path | None = None  # MF4 file of all frames; "-2" is appended to the name for the second drive
    report: Path | None = None
    # time without a frame after which the drive has ended; infinite for a single drive
    silence: Annotated[float, "s"] = 30.0
    ignition: str = ""  # column of the databases ("Message.Signal") whose zero ends the drive; "" for none
    width: int = 8


class Logs:
    """Opens the logs of successive drives, each under a name of its own."""

    def __init__(self, outputs: Outputs, plan: Plan, hub: Hub):
        self._outputs, self._plan, self._hub = outputs, plan, hub
        self.path: Path | None = None

    def begin(self, engine: Engine, drives: int) -> None:
        """Open the logs of a drive, once the origin of its clock is set."""
        self.path = self._free(self._outputs.log, drives)
        if self.path is not None:
            path, comment = self.path, f"tierod live, {self._plan.vehicle.name}"
            try:
                engine.log = FrameLog(path, engine.clock.origin, self._outputs.width, comment)
            except TierodError as error:
                self._hub.say("problem", {"text": f"{error}; monitoring goes on without a log"})

    def _free(self, path: Path | None, drives: int) -> Path | None:
        """Path of this drive's log: the next free name, as an existing file may be all that a killed session left."""
        number = drives
        while (found := numbered(path, number)) is not None and found.exists():
            number += 1
        if number > drives:
            before = numbered(path, number - 1)
            assert before is not None
            self._hub.say("problem", {"text": self._there_already(before, found)})
        return found

    def _there_already(self, before: Path, found: Path | None) -> str:
        text = f"{before} exists already; this drive is written to {found}"
        if is_unfinished(before):
            text += f". Its drive was cut off: {shlex.join(['tierod', 'diagnose', str(before), *self._plan.reading])}"
            if self._plan.memory is not None and "--memory" not in self._plan.reading:
                text += f"; the fault memory takes it with --monitor NAME --memory {self._plan.memory}"
        return text


def numbered(path: Path | None, drives: int) -> Path | None:
    """Path of a drive: as given for the first, with "-2", "-3" and so on appended for further ones."""
    return path if path is None or not drives else path.with_name(f"{path.stem}-{drives + 1}{path.suffix}")


def guarded(hub: Hub, work: Callable[[], None]) -> None:
    """Call a function, and report an error of tierod as a problem instead of raising it."""
    try:
        work()
    except TierodError as error:
        hub.say("problem", {"text": str(error)})


class Finished(NamedTuple):
    """Monitor whose drive has ended: its judge, its diagnosis, and the feed of the fault memory (None without one)."""

    judge: Judge
    diagnosis: Diagnosis
    feed: MemoryFeed | None


class Closing:
    """Writes the files at the end of a drive; a part that fails does not prevent the others.

    Args:
        report: path of the page of this drive; None writes none
        log: path of the drive's log, or None
        origin: provenance printed on the page; None writes no page
    """

    def __init__(
        self, plan: Plan, report: Path | None, log: Path | None, origin: Callable[[], Origin] | None, hub: Hub
    ):
        self._plan, self._path, self._log, self._origin, self._hub = plan, report, log, origin, hub

    def write(self, engine: Engine, finished: Sequence[Finished]) -> None:
        """Write fault memory, baselines and page, and send the event of the end."""
        with_feed = [(each.judge, each.diagnosis, each.feed) for each in finished if each.feed is not None]
        if with_feed:
            guarded(self._hub, lambda: self._hub.say("memory", {"text": remembered(with_feed, engine.identity)}))
        guarded(self._hub, lambda: self._baselines(finished))
        diagnoses = {each.judge.name: each.diagnosis for each in finished}
        guarded(self._hub, lambda: self._report(engine, diagnoses))
        first = {name: each.findings[0] for name, each in diagnoses.items()}
        verdicts = {
            name: diagnoses[name].status.document() | {"since": each.since, "end": each.end, "declared": each.declared}
            for name, each in first.items()
        }
        headlines = {name: each.headline for name, each in first.items()}
        missed = {judge.name: judge.reason for judge in engine.judges if judge.name not in diagnoses}
        status = worst(each.status for each in diagnoses.values())
        content = status.document() | {
            "time": engine.clock.latest,
            "frames": engine.tally.frames,
            "lost": engine.gaps.lost,
        }
        self._hub.say("end", content | {"verdicts": verdicts, "headlines": headlines, "not_run": missed})

    def _baselines(self, finished: Sequence[Finished]) -> None:
        for judge, diagnosis, _ in finished:
            path, learnt = judge.baseline_path, judge.run.learnt if judge.run else None
            if path is not None and learnt is not None and not path.exists():
                text = keep_first(dataclasses.replace(learnt, learnt=diagnosis.created), path)
                self._hub.say("baseline", {"monitor": judge.name, "text": text})

    def _report(self, engine: Engine, diagnoses: Mapping[str, Diagnosis]) -> None:
        if self._path is None or self._origin is None or not diagnoses:
            return
        from tierod.report import several

        judged = page(engine.judges, diagnoses, self._log or Path("live"), self._plan.vehicle.name)
        write_text(self._path, several.render([judged], self._origin()))
        self._hub.say("report", {"path": str(self._path)})


def remembered(finished: Sequence[tuple[Judge, Diagnosis, MemoryFeed]], identity: str) -> str:
    """Store the drive as one operation cycle of the fault memory, for all monitors together.

    Args:
        finished: judge, diagnosis and memory feed of every monitor that ran; at least one
        identity: identity of the drive, so that it is counted only once

    Returns:
        the outcome, in a sentence

    Raises:
        InputError: the memory holds the drive already, or its file was damaged meanwhile
        OutputError: the memory cannot be written
    """
    parts = []
    for judge, diagnosis, feed in finished:
        assert judge.run is not None
        parts.append(feed.collected(diagnosis, judge.run.course, judge.run.code_courses))
    time, results, signals = _together(parts)
    first = finished[0][2]
    with FaultMemory.changing(first.path, first.vehicle, load_trouble_codes()) as memory:
        memory.begin_cycle(finished[0][1].created, identity)
        memory.absorb(time, results, signals)
        memory.end_cycle()
    return f"the drive is operation cycle {memory.cycles} of the fault memory {first.path}"


def _together(parts: Sequence[Results]) -> Results:
    """Results and signals of several monitors on the union of their times.

    Between the samples of a monitor its trouble codes have no result (0), and its signals hold their last value.
    """
    time = np.unique(np.concatenate([part[0] for part in parts]))
    results: dict[str, np.ndarray] = {}
    signals: dict[str, np.ndarray] = {}
    for own, codes, measured in parts:
        at = np.searchsorted(time, own)
        for name, values in codes.items():
            results.setdefault(name, np.zeros(len(time)))[at] = values
        before = np.maximum(np.searchsorted(own, time, "right") - 1, 0)
        for name, values in measured.items():
            signals.setdefault(name, values[before])
    return time, results, signals


def page(judges: Sequence[Judge], diagnoses: Mapping[str, Diagnosis], path: Path, vehicle: str) -> Judged:
    """Findings of the monitors in the form of the page of `tierod diagnose --monitor all`."""
    missed = tuple(NotRun(each.name, each.reason) for each in judges if each.name not in diagnoses)
    return Judged(path, vehicle, dict(diagnoses), missed)
