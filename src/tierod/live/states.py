"""States of monitors for a checkpoint, and objects that are opened before they are filled from it."""

from __future__ import annotations

from typing import Any

from tierod.live.checkpoint import State
from tierod.live.judge import Judge
from tierod.live.restoring import Held, Opening
from tierod.live.snapshot import NotStorable, Snapshot, digest_of, digest_of_block, snapshot
from tierod.monitors.harness.run import Run
from tierod.monitors.harness.session import BlockSession
from tierod.monitors.harness.spread.parameter_spread import ParameterSpread


def _reopen_run(run: Run, held: Held) -> None:
    if held.node("_spread") is not None:
        run.open_spread()


def _reopen_spread(spread: ParameterSpread, held: Held) -> None:
    spread.reopen(_moves(held.node("_screen")), _moves(held.node("_carried")))


def _refit(session: BlockSession, held: Held) -> None:
    if held.node("fitted") is not None:
        session.refit(held.value("fitted"))


def _moves(node: Any) -> list[dict[str, float]]:
    """Parameter moves of the perturbed vehicles in a snapshot, in standard deviations; one entry per vehicle."""
    if node is None:
        return []
    running = dict(dict(node[3])["points"][3])["running"]
    points = {place: dict(point[3])["by"] for place, point in running[3]}
    moves: list[dict[str, float]] = [{} for _ in range(max(points, default=-1) + 1)]
    for place, by in points.items():
        moves[place] = dict(by[3])
    return moves


OPENINGS: dict[type, Opening] = {Run: _reopen_run, ParameterSpread: _reopen_spread, BlockSession: _refit}


def packages_of(judge: Judge) -> frozenset[str]:
    """Top-level packages whose classes a checkpoint of a monitor may hold: tierod, and the package of the monitor."""
    session = judge.run.session if judge.run is not None else None
    return frozenset({"tierod", type(session).__module__.partition(".")[0]})


def state_of(judge: Judge, collected: bool = True) -> State | None:
    """State of a monitor for a checkpoint; None if the monitor does not run.

    Args:
        judge: judge of the monitor
        collected: whether to include the data collected over the drive beside the state of its block
    """
    run = judge.run
    if run is None or judge.broken or not run.begun:
        return None
    held: Snapshot | None = None
    try:
        held = snapshot(judge.held(), packages_of(judge)) if collected else None
    except NotStorable:
        held = None
    block, memory = "", None
    if isinstance(run.session, BlockSession):
        block, memory = digest_of_block(run.session.block), run.session.memory
    return State(block, memory, calibration(judge), run.variant.name, run.monitor.rate, held)


def calibration(judge: Judge) -> str:
    """Digest of the baseline with which the session of a monitor is opened."""
    return digest_of(judge.calibration)
