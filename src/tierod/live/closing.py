"""Results at the end of a drive: one operation cycle of the fault memory, the HTML page, and new baselines."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tierod.core.files import write_text
from tierod.core.findings import Diagnosis
from tierod.core.statuses import worst
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.live.engine import Engine
from tierod.live.events import Hub
from tierod.live.judge import Judge, Plan
from tierod.live.outputs import guarded
from tierod.monitors.harness.baseline import keep_first
from tierod.monitors.several import Judged, NotRun

if TYPE_CHECKING:
    from tierod.monitors.harness.into_memory import MemoryFeed
    from tierod.report.html import Origin

Results = tuple[np.ndarray, dict[str, np.ndarray], dict[str, np.ndarray]]


class Finished(NamedTuple):
    """Monitor whose drive has ended: its judge, its diagnosis, and the feed of the fault memory (None without one)."""

    judge: Judge
    diagnosis: Diagnosis
    feed: MemoryFeed | None


class Closing:
    """Writes the files at the end of a drive; a part that fails does not prevent the others.

    Args:
        plan: settings of the session
        report: path of the page of this drive; None writes none
        log: path of the drive's log, or None
        origin: provenance printed on the page; None writes no page
        hub: receives the outcome of each part
    """

    def __init__(
        self, plan: Plan, report: Path | None, log: Path | None, origin: Callable[[], Origin] | None, hub: Hub
    ):
        self._plan, self._path, self._log, self._origin, self._hub = plan, report, log, origin, hub

    def write(self, engine: Engine, finished: Sequence[Finished]) -> None:
        """Write fault memory, baselines and page, and send the event of the end.

        Args:
            engine: engine of the drive
            finished: every monitor that ran
        """
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
    """Findings of the monitors in the form of the page of `tierod diagnose --monitor all`.

    Args:
        judges: judges of the drive
        diagnoses: diagnoses by name of the monitor
        path: path of the log, or its placeholder
        vehicle: name of the vehicle
    """
    missed = tuple(NotRun(each.name, each.reason) for each in judges if each.name not in diagnoses)
    return Judged(path, vehicle, dict(diagnoses), missed)
