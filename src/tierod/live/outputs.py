"""Paths of a live session's results, and the free name for each of its drives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tierod.core.errors import TierodError
from tierod.live.engine import Engine
from tierod.live.events import Hub
from tierod.live.findings import Findings
from tierod.live.judge import Plan
from tierod.live.log import FrameLog, is_unfinished
from tierod.live.mcap_log import McapLog


@dataclass(frozen=True)
class Outputs:
    """Paths of a session's results.

    Args:
        log: MF4 file of all frames; the second drive gets "-2" behind its name
        report: HTML page at the end of a drive
        checkpoint: file of states and statements
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


class Logs:
    """The logs of one drive after the other, each with a name of its own.

    Args:
        outputs: names of the first drive
        plan: of the session
        hub: takes what is wrong with a log
    """

    def __init__(self, outputs: Outputs, plan: Plan, hub: Hub):
        self._outputs, self._plan, self._hub = outputs, plan, hub
        self.path: Path | None = None
        self.concluded: Path | None = None
        """Log of a drive that was cut off, and is concluded now."""
        self._mcap: Findings | None = None

    def begin(self, engine: Engine, drives: int, goes_on: bool) -> None:
        """Open the logs of a drive whose time is known.

        Args:
            engine: of the drive
            drives: that have ended
            goes_on: whether a drive goes on from a checkpoint, so that its first part lies in the log before
        """
        self.path = self._free(self._outputs.log, drives, goes_on)
        if self.path is not None:
            path, comment = self.path, f"tierod live, {self._plan.vehicle.name}"
            try:
                engine.log = FrameLog(path, engine.clock.origin, self._outputs.width, comment)
            except TierodError as error:
                self._hub.say("problem", {"text": f"{error}; monitoring goes on without a log"})
        if self._outputs.mcap is not None:
            guarded(self._hub, lambda: self._open_mcap(engine, drives, goes_on))

    def _open_mcap(self, engine: Engine, drives: int, goes_on: bool) -> None:
        path = self._free(self._outputs.mcap, drives, goes_on)
        assert path is not None
        self._mcap = Findings(McapLog(path, engine.clock.origin), engine, self._hub)

    def end(self) -> None:
        """Finish what is not the engine's."""
        if self._mcap is not None:
            guarded(self._hub, self._mcap.close)
            self._mcap = None

    def _free(self, path: Path | None, drives: int, goes_on: bool) -> Path | None:
        """Path of this drive's log: the next name that is free, since what is there may be all that a kill left."""
        number = drives
        while (found := numbered(path, number)) is not None and found.exists():
            number += 1
        if number > drives:
            before = numbered(path, number - 1)
            assert before is not None
            self._hub.say("problem", {"text": self._there_already(before, found, goes_on)})
        return found

    def _there_already(self, before: Path, found: Path | None, goes_on: bool) -> str:
        if goes_on:
            return f"{before} is there already and holds the drive up to the restart; it goes on in {found}"
        text = f"{before} is there already; this drive is {found}"
        known = self.concluded is not None and before.absolute() == self.concluded.absolute()
        if is_unfinished(before) and self._plan.memory is not None and not known:
            words = f"tierod diagnose {before} --vehicle {self._plan.vehicle.name} --memory {self._plan.memory}"
            text += f". Its drive was cut off and is not in the fault memory: {words} takes it there"
        return text


def numbered(path: Path | None, drives: int) -> Path | None:
    """The path of a drive: as given for the first, with a number behind its name for the others."""
    return path if path is None or not drives else path.with_name(f"{path.stem}-{drives + 1}{path.suffix}")


def guarded(hub: Hub, work: Callable[[], None]) -> None:
    """Do some work, and report the error where it fails.

    Args:
        hub: takes the sentence
        work: that may raise errors of tierod
    """
    try:
        work()
    except TierodError as error:
        hub.say("problem", {"text": str(error)})
