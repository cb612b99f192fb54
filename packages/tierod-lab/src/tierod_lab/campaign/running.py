"""Execution of a campaign's missing cells in parallel: first the drives that set baselines, then all others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

from tierod.core.block import structure
from tierod.core.errors import TierodError
from tierod.core.graph.kernel import kernel
from tierod.monitors.harness.baseline import Baseline
from tierod.work.pool import Failure, Workers
from tierod_lab.campaign.plan import Cell, Judge, Plan
from tierod_lab.campaign.store import Store
from tierod_lab.campaign.work import DRIVEN, Reference, Task, Verdict, code, failed, work
from tierod_lab.ground.faults import Always

TASTE = 0.5
"""Duration of the trial drives in the parent, which compile every kernel for the workers [s]."""


class Progress(NamedTuple):
    """Progress of a campaign.

    Args:
        done: number of finished cells, including those of earlier runs
        name: name of the cell that has just finished; "" before the first, when all kernels are compiled
    """

    done: int
    total: int
    name: str
    outcome: str


def run(plan: Plan, store: Store, workers: Workers, progress: Callable[[Progress], None] = lambda _: None) -> None:
    """Simulate and judge all missing cells."""
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
