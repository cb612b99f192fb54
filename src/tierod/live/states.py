"""States of monitors as a checkpoint keeps them, and what is opened anew before they are filled with it."""

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
    """Standard deviations by parameter, by place, of vehicles in a snapshot; empty where there was none."""
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
    """Packages whose classes a checkpoint of a monitor holds: tierod's, and that of the monitor."""
    session = judge.run.session if judge.run is not None else None
    return frozenset({"tierod", type(session).__module__.partition(".")[0]})


def state_of(judge: Judge, collected: bool = True) -> State | None:
    """State of a monitor to keep; None where it does not run.

    Args:
        judge: of the monitor
        collected: whether with what it collected over the drive, beside the state of its block
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
    """Digest of what the session of a monitor is opened for."""
    return digest_of(judge.calibration)
