"""Execution of a campaign's missing cells in parallel: first the drives that set baselines, then all others."""

from __future__ import annotations

import dataclasses
import json
import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

from tierod.core.block import structure
from tierod.core.errors import CompileError, MissingExtra, OutputError, TierodError
from tierod.core.graph.kernel import kernel
from tierod.core.recording import Recording
from tierod.core.version import __version__
from tierod.monitors.baseline import Baseline
from tierod.work.pool import Failure, Passing, Workers
from tierod_lab.campaign.code import ground_code, judging_code
from tierod_lab.campaign.judging import Window, json_value, judge
from tierod_lab.campaign.plan import Cell, Judge, Plan, window_of
from tierod_lab.campaign.store import Store
from tierod_lab.ground.faults import Always

DRIVEN, DIVERGED, FAILED = "driven", "diverged", "failed"  # Outcomes of a drive


class Reference(NamedTuple):
    """Baseline for a verdict."""

    level: Baseline | None = None  # baseline from another drive; None if the monitor learns its own
    refusal: str = ""  # reason why a required baseline is missing; "" otherwise
    lasting: bool = True  # whether it would be missing again


class Verdict(NamedTuple):
    """One verdict to be made."""

    judge: Judge
    name: str
    key: str
    reference: Reference


@dataclass(frozen=True)
class Task:
    """Work on one cell."""

    store: Store
    cell: Cell
    verdicts: tuple[Verdict, ...]
    settling: float  # see `tierod_lab.campaign.matrix.CampaignFile`
    keep: bool
    code: tuple[str, str]  # digests of tierod's code at the start of the campaign


def work(task: Task) -> str:
    """Process a task, and return the outcome of its drive."""
    if task.code != code():
        raise Passing("the code of tierod has changed since the campaign began; run it again")
    drive, recording = _driven(task)
    if drive["outcome"] == DRIVEN:
        fault = window_of(drive["windows"])
        for verdict in task.verdicts:
            record = _judged(task, verdict, recording, fault)
            task.store.keep_verdict(verdict.name, verdict.key, record)
    return str(drive["outcome"])


def code() -> tuple[str, str]:
    """Digests of the code for drives and of the code for verdicts."""
    return ground_code(), judging_code()


def _driven(task: Task) -> tuple[Mapping[str, Any], Recording]:
    store, cell = task.store, task.cell
    kept = store.drive(cell.name, cell.key)
    if kept is not None and (recording := store.recording(kept)) is not None:
        return kept, recording
    outcome = cell.scenario.run()
    at = outcome.diverged_at
    record = _record(cell, DRIVEN) | {
        "windows": _plain(outcome.windows),
        "recording": store.keep_recording(cell.name, cell.key, outcome.recording) if task.keep else None,
    }
    if at is not None:
        reason = f"the run did not stay within its limits; its last good time is {at:.6g} s"
        record |= {"outcome": DIVERGED, "reason": reason, "last_good_s": at}
    store.keep_drive(cell.name, cell.key, record)
    return record, outcome.recording


def _record(cell: Cell, outcome: str, reason: str = "", lasting: bool = True) -> dict[str, Any]:
    return {
        "outcome": outcome,
        "reason": reason,
        "last_good_s": None,
        "lasting": lasting,
        "place": dict(cell.point.place),
        "windows": [],
        "recording": None,
        "provenance": {"scenario": _plain(cell.scenario.provenance), **_machine()},
    }


def _judged(task: Task, verdict: Verdict, recording: Recording, fault: Window | None) -> dict[str, Any]:
    record: dict[str, Any] = {"monitor": verdict.judge.label, "drive": task.cell.key, "judged": None, "baseline": None}
    if verdict.reference.refusal:
        return record | {"reason": verdict.reference.refusal, "lasting": verdict.reference.lasting}
    chosen = verdict.judge
    try:
        judged, learnt = judge(recording, chosen.found(), chosen.belief, verdict.reference.level, fault, task.settling)
    except OutputError:
        raise
    except TierodError as error:
        reason = " ".join(str(error).split())
        return record | {"reason": reason, "lasting": not isinstance(error, CompileError | MissingExtra)}
    except (ArithmeticError, LookupError, RuntimeError, TypeError, ValueError) as error:
        text = f"a defect of tierod itself: {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        return record | {"reason": text, "lasting": True}
    own = None if learnt is None else dataclasses.asdict(learnt)
    return record | {"reason": "", "lasting": True, "judged": json_value(dataclasses.asdict(judged)), "baseline": own}


@cache
def _machine() -> dict[str, Any]:
    import numpy

    from tierod.core.graph.compiler import compiler
    from tierod.core.graph.kernel import is_interpreted

    command = compiler()
    return {
        "version": __version__,
        "python": platform.python_version(),
        "numpy": numpy.__version__,
        "platform": platform.platform(),
        "compiler": "virtual machine" if is_interpreted() or command is None else " ".join(command),
    }


def _plain(value: object) -> Any:
    return json.loads(json.dumps(json_value(value), default=str, allow_nan=False))


TASTE = 0.5  # Duration of the trial drives in the parent, which compile every kernel for the workers [s]


class Progress(NamedTuple):
    """Progress of a campaign."""

    done: int  # number of finished cells, including those of earlier runs
    total: int
    name: str  # name of the cell that has just finished; "" before the first, when all kernels are compiled
    outcome: str


def run(plan: Plan, store: Store, workers: Workers, progress: Callable[[Progress], None] = lambda _: None) -> None:
    """Simulate and judge all missing cells."""
    missing = [number for number, cell in enumerate(plan.cells) if not plan.done(cell, store)]
    done, total = len(plan.cells) - len(missing), len(plan.cells)
    first, then = ([each for each in missing if (plan.cells[each].reference is None) == own] for own in (True, False))
    with workers as executor:
        executor.start(work, len(missing))
        compile_once([plan.cells[number] for number in missing], plan.judges if missing else ())
        progress(Progress(done, total, "", ""))
        for part in (first, then):
            tasks = [_task(plan, store, plan.cells[number]) for number in part]
            for at, result in executor.run(work, tasks):
                cell = tasks[at].cell
                if isinstance(result, Failure):
                    store.keep_drive(cell.name, cell.key, _record(cell, FAILED, result.reason, result.lasting))
                    result = "failed"
                done += 1
                progress(Progress(done, total, cell.name, str(result)))


def compile_once(cells: Sequence[Cell], judges: Sequence[Judge]) -> None:
    """Compile every kernel before the workers start, which would otherwise all compile the same ones."""
    tasted = set()
    for cell in cells:
        elements = tuple(effect.element for fault in cell.scenario.faults for effect in fault.effects)
        shape = (repr(structure(cell.scenario.car)), elements)
        if shape not in tasted:
            tasted.add(shape)
            # Faults act from the start here, since the trial drive is over before most of them would start.
            faults = tuple(replace(fault, trigger=Always(), duration=None) for fault in cell.scenario.faults)
            try:
                replace(cell.scenario, faults=faults).with_run(seconds=TASTE).run()
            except TierodError:
                continue  # reported when the cell itself is simulated
    for each in judges:
        monitor, variant = each.found()
        block = getattr(variant.open(each.belief, monitor.rate, None), "block", None)
        if block is not None:
            kernel(block)


def _task(plan: Plan, store: Store, cell: Cell) -> Task:
    open_ = plan.open_judges(cell, store)
    named = [(judge, plan.verdict_name(cell, judge), plan.verdict_key(cell, judge)) for judge in open_]
    verdicts = tuple(Verdict(*each, _reference(plan, store, cell, each[0])) for each in named)
    return Task(store, cell, verdicts, plan.settling, plan.keep, code())


def _reference(plan: Plan, store: Store, cell: Cell, judge: Judge) -> Reference:
    if cell.reference is None or not judge.learns:
        return Reference()
    reference = plan.cells[cell.reference]
    record = plan.verdict(reference, judge, store)
    known = None if record is None else record["baseline"]
    if known is not None:
        return Reference(Baseline(**known))
    if record is not None:
        judged, lasting = record["judged"], record["lasting"]
        why = f"it was judged '{judged['status']}'" if judged else record["reason"]
    else:
        drive = store.drive(reference.name, reference.key) or {"outcome": "not driven", "lasting": False}
        why, lasting = f"it was {drive['outcome']}", drive["lasting"] and drive["outcome"] != DRIVEN
    return Reference(None, f"the first fault-free drive of this car ({reference.name}) set no baseline: {why}", lasting)
