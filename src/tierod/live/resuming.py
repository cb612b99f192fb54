"""Checkpoints of a drive: what is kept every few seconds, and going on from it after a program ended."""

from __future__ import annotations

import datetime
import math
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tierod.core.errors import OutputError, TierodError
from tierod.live import checkpoint
from tierod.live.agreement import layout
from tierod.live.checkpoint import OLDEST, Checkpoint, State
from tierod.live.engine import Engine
from tierod.live.judge import Judge
from tierod.live.log import tail
from tierod.live.restoring import Held, Opening, Unfit, restored
from tierod.live.snapshot import NotStorable, Snapshot, digest_of, digest_of_block, snapshot
from tierod.monitors.harness.run import Run
from tierod.monitors.harness.session import BlockSession
from tierod.monitors.harness.spread.parameter_spread import ParameterSpread

if TYPE_CHECKING:
    from cantools.database.can import Message

    from tierod.io.readers.channel_map import ChannelMap
    from tierod.vehicles import Vehicle


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
    """What is kept of a monitor; None where it does not run.

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
    return State(block, memory, _calibration(judge), run.variant.name, run.monitor.rate, held)


def _calibration(judge: Judge) -> str:
    return digest_of(judge.calibration)


def databases_digest(database: Sequence[Message], channel_map: ChannelMap | None) -> str:
    """Digest of how signals are made from frames.

    Args:
        database: messages of all databases
        channel_map: which makes canonical signals
    """
    messages = [(each.frame_id, each.name, *map(layout, each.signals)) for each in database]
    return digest_of(messages, channel_map.entries if channel_map is not None else None)


class Checkpoints:
    """Keeps the checkpoint of one session in a file, and takes up what lies there.

    Args:
        path: of the file
        vehicle: that drives
        databases: digest of messages and channel map
        say: takes sentences on what became of it, with the name of a monitor or ""
    """

    def __init__(self, path: Path, vehicle: Vehicle, databases: str, say: Callable[[str, str], None]):
        self.path, self._vehicle, self._databases, self._say = path, vehicle, databases, say
        self._pool = ThreadPoolExecutor(1, "checkpoint")
        self._writing: Future[None] | None = None
        self.judged_until = -math.inf
        """Time of the drive up to which the last checkpoint holds it [s]."""
        self._states: dict[str, State] = {}
        self.found = self._read() if path.exists() else None

    def _read(self) -> Checkpoint | None:
        try:
            found = checkpoint.read(self.path)
            if reason := self._unfit(found):
                raise checkpoint.refused(self.path, reason)
        except TierodError as error:
            self._say("", str(error))
            return None
        return found

    def _unfit(self, found: Checkpoint) -> str:
        own = checkpoint.of_vehicle(self._vehicle)
        if found.vehicle != self._vehicle.name:
            return f"it is of the vehicle '{found.vehicle}', and this is '{self._vehicle.name}'"
        if found.car != own:
            return f"the parameters of the vehicle '{found.vehicle}' have changed since"
        if found.databases != self._databases:
            return "the CAN databases or the channel map have changed since"
        if not -checkpoint.AHEAD <= found.age <= OLDEST:
            return f"it is {found.age:.0f} s old, and {OLDEST:.0f} s are the limit"
        return ""

    def resume(self, engine: Engine) -> bool:
        """Go on with the drive of the file, if it has not ended: its clock, its statements, and what was logged since.

        Args:
            engine: new

        Returns:
            whether it goes on
        """
        found = self.found
        if found is None or found.ended or found.drive is None:
            self._states = {} if found is None else dict(found.states)
            return False
        try:
            engine.resume(restored(found.drive, engine.held(), frozenset({"tierod"}), OPENINGS))
        except (Unfit, KeyError) as error:
            self._say("", str(checkpoint.refused(self.path, f"it does not fit this program ({error})")))
            return False
        engine.clock.shift(found.clock - (time.time() - time.monotonic()))
        for judge in engine.judges:
            self._resume_monitor(judge, found.states.get(judge.name))
        again = engine.again(tail(Path(found.log), engine.judged_until)) if found.log else 0
        since = datetime.datetime.fromtimestamp(found.written).isoformat(" ", "seconds")
        more = f", and {again} frames that were logged since" if again else ""
        self._say("", f"the drive goes on from the checkpoint of {since}{more}")
        return True

    def _resume_monitor(self, judge: Judge, state: State | None) -> None:
        if state is None or judge.broken:
            return
        if state.calibration != _calibration(judge):
            self._say(judge.name, "its baseline is another one than that of the checkpoint; it begins anew")
            return
        try:
            opened = judge.reopen(state.variant, state.rate)
            if state.held is None:
                raise Unfit("what it collected was not written")
            judge.resume(restored(state.held, opened, packages_of(judge), OPENINGS))
        except (Unfit, TierodError, KeyError) as error:
            judge.begin_anew()
            self._states[judge.name] = state
            self._say(judge.name, f"its statements begin anew: the checkpoint does not fit this program ({error})")
            return
        self._say(judge.name, "goes on from the checkpoint")

    def settle(self, judges: Sequence[Judge]) -> None:
        """States of a drive that has ended go into the blocks of monitors that have begun.

        Args:
            judges: all monitors
        """
        for judge in judges if self._states else ():
            state, run = self._states.get(judge.name), judge.run
            if state is None or run is None or not run.begun:
                continue
            del self._states[judge.name]
            own = digest_of_block(run.session.block) if isinstance(run.session, BlockSession) else ""
            if state.memory is not None and own == state.block:
                judge.go_on(state.memory)
                self._say(judge.name, "its block goes on from the state at the end of the drive before")
            else:
                self._say(judge.name, "the checkpoint is of another calibration; it begins anew")

    def collected(self, judges: Sequence[Judge]) -> dict[str, State]:
        """What is kept of all monitors, when a piece was judged; some milliseconds each.

        Args:
            judges: of the drive
        """
        return {judge.name: each for judge in judges if (each := state_of(judge)) is not None}

    def store(self, engine: Engine, states: Mapping[str, State], now: float, calendar: float, log: Path | None) -> None:
        """Write what the drive holds now; a thread does, and what comes before it has ended is left out.

        Args:
            engine: of the drive, before the next piece is judged
            states: of its monitors, as of `collected`
            now: by the computer's clock [s]
            calendar: time of the computer [s]
            log: of the drive

        Raises:
            OutputError: the one before could not be written
        """
        if self._writing is not None and not self._writing.done():
            return
        self._raise_late()
        drive, self.judged_until = snapshot(engine.held()), engine.judged_until
        content = self._content(states, calendar - now, drive, str(log.absolute()) if log else "")
        self._writing = self._pool.submit(checkpoint.written, content, self.path)

    def store_end(self, judges: Sequence[Judge]) -> None:
        """Write that the drive has ended, and the states of the blocks.

        Args:
            judges: of the drive, which was concluded

        Raises:
            OutputError: it cannot be written
        """
        if self._writing is not None:
            self._writing.exception()
        self._writing = None
        states = {judge.name: each for judge in judges if (each := state_of(judge, collected=False)) is not None}
        checkpoint.written(self._content(states, 0.0, None, ""), self.path)

    def _content(self, states: Mapping[str, State], clock: float, drive: Snapshot | None, log: str) -> Checkpoint:
        """What is written; without what the drive holds it has ended."""
        written = datetime.datetime.now(datetime.UTC).timestamp()
        own = checkpoint.of_vehicle(self._vehicle)
        ended = drive is None
        return Checkpoint(self._vehicle.name, own, self._databases, written, clock, ended, states, drive, log)

    def close(self) -> None:
        """End the thread that writes, when the file is whole."""
        self._pool.shutdown()

    def _raise_late(self) -> None:
        if self._writing is not None:
            error = self._writing.exception()
            self._writing = None
            if isinstance(error, OutputError):
                raise error
            assert error is None, error
