"""Checkpoints of a drive, written every few seconds, and resumption from them after a program ended."""

from __future__ import annotations

import datetime
import math
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

from tierod.core.errors import OutputError, TierodError
from tierod.live import checkpoint
from tierod.live.agreement import layout
from tierod.live.checkpoint import OLDEST, Checkpoint, State
from tierod.live.engine import Engine
from tierod.live.judge import Judge
from tierod.live.log import tail
from tierod.live.restoring import Unfit, restored
from tierod.live.snapshot import Snapshot, digest_of, digest_of_block, snapshot
from tierod.live.states import OPENINGS, calibration, packages_of, state_of
from tierod.monitors.harness.session import BlockSession

if TYPE_CHECKING:
    from cantools.database.can import Message

    from tierod.io.readers.channel_map import ChannelMap
    from tierod.vehicles import Vehicle


def databases_digest(database: Sequence[Message], channel_map: ChannelMap | None) -> str:
    """Digest of the conversion of frames into signals.

    Args:
        database: messages of all databases
        channel_map: conversion into canonical signals
    """
    messages = [(each.frame_id, each.name, *map(layout, each.signals)) for each in database]
    return digest_of(messages, channel_map.entries if channel_map is not None else None)


def _since(found: Checkpoint) -> str:
    return datetime.datetime.fromtimestamp(found.written).isoformat(" ", "seconds")


def _old(found: Checkpoint) -> str:
    return f"it is {found.age:.0f} s old, and {OLDEST:.0f} s are the limit"


class Checkpoints:
    """Keeps the checkpoint of one session in a file, and resumes from an existing one.

    Args:
        path: path of the file
        vehicle: the vehicle driven
        databases: digest of the messages and the channel map
        say: receives the name of a monitor or "", and a sentence on the outcome
    """

    def __init__(self, path: Path, vehicle: Vehicle, databases: str, say: Callable[[str, str], None]):
        self.path, self._vehicle, self._databases, self._say = path, vehicle, databases, say
        self._pool = ThreadPoolExecutor(1, "checkpoint")
        self._writing: Future[None] | None = None
        self.judged_until = -math.inf
        """Time of the drive up to which the last checkpoint covers it [s]."""
        self._states: dict[str, State] = {}
        self.cut_off: Checkpoint | None = None
        """Checkpoint of a drive that did not end and is too old to be resumed."""
        self.found = self._read() if path.exists() else None

    def _read(self) -> Checkpoint | None:
        try:
            found = checkpoint.read(self.path)
            if reason := self._unfit(found):
                raise checkpoint.refused(self.path, reason)
            if found.age > OLDEST:
                if found.drive is None or found.ended:
                    raise checkpoint.refused(self.path, _old(found))
                self.cut_off = found
                return None
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
        if found.age < -checkpoint.AHEAD:
            return _old(found)
        return ""

    def resume(self, engine: Engine) -> bool:
        """Resume the drive of the checkpoint if it has not ended: its clock, its results, and frames logged since.

        Args:
            engine: a new engine

        Returns:
            whether a drive was resumed
        """
        found = self.found
        if found is None or found.ended or found.drive is None:
            self._states = {} if found is None else dict(found.states)
            return False
        again = self._restored(engine, found, found.clock - (time.time() - time.monotonic()))
        if again is None:
            return False
        more = f", and {again} frames that were logged since" if again else ""
        self._say("", f"the drive goes on from the checkpoint of {_since(found)}{more}")
        return True

    def conclude(self, engine: Engine) -> Path | None:
        """Restore the interrupted drive into an engine, to be finished.

        Args:
            engine: a new engine

        Returns:
            its log, or a placeholder; None where the checkpoint does not fit this program
        """
        found = self.cut_off
        if found is None or (again := self._restored(engine, found, 0.0)) is None:
            return None
        more = f" and {again} frames that were logged since" if again else ""
        self._say(
            "",
            f"the drive that was cut off at about {_since(found)} is too old to continue: it is concluded from its "
            f"checkpoint{more}",
        )
        return Path(found.log or "live")

    def forget(self) -> None:
        """Write a checkpoint without an open drive and without states.

        Raises:
            OutputError: the checkpoint cannot be written
        """
        checkpoint.written(self._content({}, 0.0, None, ""), self.path)

    def _restored(self, engine: Engine, found: Checkpoint, shift: float) -> int | None:
        """Restore a drive into an engine, and return the number of frames added from its log; None if it does not fit.

        Args:
            engine: a new engine
            found: checkpoint of the drive
            shift: lead of the computer's monotonic clock over the one at the time of writing [s]
        """
        if found.drive is None:
            return None
        try:
            engine.resume(restored(found.drive, engine.held(), frozenset({"tierod"}), OPENINGS))
        except (Unfit, KeyError) as error:
            self._say("", str(checkpoint.refused(self.path, f"it does not fit this program ({error})")))
            return None
        engine.clock.shift(shift)
        for judge in engine.judges:
            self._resume_monitor(judge, found.states.get(judge.name))
        return engine.again(tail(Path(found.log), engine.judged_until)) if found.log else 0

    def _resume_monitor(self, judge: Judge, state: State | None) -> None:
        if state is None or judge.broken:
            return
        if state.calibration != calibration(judge):
            self._say(judge.name, "its baseline differs from that of the checkpoint; it begins anew")
            return
        try:
            opened = judge.reopen(state.variant, state.rate)
            if state.held is None:
                raise Unfit("its collected data were not written")
            judge.resume(restored(state.held, opened, packages_of(judge), OPENINGS))
        except (Unfit, TierodError, KeyError) as error:
            judge.begin_anew()
            self._states[judge.name] = state
            self._say(judge.name, f"its findings begin anew: the checkpoint does not fit this program ({error})")
            return
        self._say(judge.name, "goes on from the checkpoint")

    def settle(self, judges: Sequence[Judge]) -> None:
        """Put the block states at the end of the previous drive into the blocks of monitors that have begun.

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
                self._say(judge.name, "the checkpoint belongs to another calibration; it begins anew")

    def collected(self, judges: Sequence[Judge]) -> dict[str, State]:
        """States of all monitors for a checkpoint, after a piece was judged; takes some milliseconds per monitor.

        Args:
            judges: judges of the drive
        """
        return {judge.name: each for judge in judges if (each := state_of(judge)) is not None}

    def store(self, engine: Engine, states: Mapping[str, State], now: float, calendar: float, log: Path | None) -> None:
        """Write the current state of the drive in a thread; skipped while the previous write is still running.

        Args:
            engine: engine of the drive, before the next piece is judged
            states: states of its monitors, as given by `collected`
            now: time of the computer's monotonic clock [s]
            calendar: calendar time of the computer [s]
            log: path of the drive's log

        Raises:
            OutputError: the previous checkpoint could not be written
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
            judges: judges of the concluded drive

        Raises:
            OutputError: the checkpoint cannot be written
        """
        # Waits for a write that is still running, which would overwrite the end of the drive.
        if self._writing is not None:
            self._writing.exception()
        self._writing = None
        states = {judge.name: each for judge in judges if (each := state_of(judge, collected=False)) is not None}
        checkpoint.written(self._content(states, 0.0, None, ""), self.path)

    def _content(self, states: Mapping[str, State], clock: float, drive: Snapshot | None, log: str) -> Checkpoint:
        """Content of a checkpoint; without a state of the drive it marks the end of the drive."""
        written = datetime.datetime.now(datetime.UTC).timestamp()
        own = checkpoint.of_vehicle(self._vehicle)
        ended = drive is None
        return Checkpoint(self._vehicle.name, own, self._databases, written, clock, ended, states, drive, log)

    def close(self) -> None:
        """Stop the writing thread after the file is complete."""
        self._pool.shutdown()

    def _raise_late(self) -> None:
        if self._writing is not None:
            error = self._writing.exception()
            self._writing = None
            if isinstance(error, OutputError):
                raise error
            assert error is None, error
