"""Runs what a campaign lacks, on all cores: first the drives that set baselines, then those judged against them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

from tierod.core.block import structure
from tierod.core.errors import TierodError
from tierod.core.graph.kernel import kernel
from tierod.experiments.executor import Failure, Workers
from tierod.experiments.plan import Cell, Judge, Plan
from tierod.experiments.store import Store
from tierod.experiments.work import DRIVEN, Reference, Task, Verdict, code, failed, work
from tierod.monitors.harness.baseline import Baseline
from tierod.proving_ground.faults import Always

TASTE = 0.5
"""Seconds that are driven in the parent, so that the workers find every kernel compiled."""


class Progress(NamedTuple):
    """Progress of a campaign.

    Args:
        done: cells that are finished, those of earlier runs included
        total: of all cells
        name: of the cell that has just been finished; "" before the first, when everything is compiled
        outcome: of that one
    """

    done: int
    total: int
    name: str
    outcome: str


def run(plan: Plan, store: Store, workers: Workers, progress: Callable[[Progress], None] = lambda _: None) -> None:
    """Drive and judge whatever is not there yet.

    Args:
        plan: all cells
        store: where everything is kept; prepared, and held alone
        workers: which do the work, opened and closed here; those of a cluster have to reach the store's folder
        progress: called as each cell ends

    Raises:
        OutputError: the disk is full, for example; what was finished before is kept
    """
    missing = [number for number, cell in enumerate(plan.cells) if not plan.done(cell, store)]
    done, total = len(plan.cells) - len(missing), len(plan.cells)
    first = [number for number in missing if plan.cells[number].reference is None]
    then = [number for number in missing if plan.cells[number].reference is not None]
    with workers as executor:
        executor.start(work, len(missing))
        compile_once([plan.cells[number] for number in missing], plan.judges if missing else ())
        progress(Progress(done, total, "", ""))
        for part in (first, then):
            tasks = [_task(plan, store, plan.cells[number]) for number in part]
            for at, result in executor.run(work, tasks):
                cell = tasks[at].cell
                if isinstance(result, Failure):
                    store.keep_drive(cell.name, cell.key, failed(cell, result.reason, result.lasting))
                    result = "failed"
                done += 1
                progress(Progress(done, total, cell.name, str(result)))


def compile_once(cells: Sequence[Cell], judges: Sequence[Judge]) -> None:
    """Let every kernel be compiled before the workers start, which would otherwise all compile the same."""
    tasted = set()
    for cell in cells:
        elements = tuple(effect.element for fault in cell.scenario.faults for effect in fault.effects)
        shape = (repr(structure(cell.scenario.car)), elements)
        if shape not in tasted:
            tasted.add(shape)
            # From the beginning: what is driven is over before most faults come.
            faults = tuple(replace(fault, trigger=Always(), duration=None) for fault in cell.scenario.faults)
            try:
                replace(cell.scenario, faults=faults).with_run(seconds=TASTE).run()
            except TierodError:
                continue  # reported where the cell itself is driven
    for judge in judges:
        monitor, variant = judge.found()
        block = getattr(variant.open(judge.belief, monitor.rate, None), "block", None)
        if block is not None:
            kernel(block)


def _task(plan: Plan, store: Store, cell: Cell) -> Task:
    verdicts = tuple(
        Verdict(
            judge, plan.verdict_name(cell, judge), plan.verdict_key(cell, judge), _reference(plan, store, cell, judge)
        )
        for judge in plan.open_judges(cell, store)
    )
    return Task(store, cell, verdicts, plan.settling, plan.keep, code())


def _reference(plan: Plan, store: Store, cell: Cell, judge: Judge) -> Reference:
    """Baseline from the first fault-free drive of the same car."""
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
