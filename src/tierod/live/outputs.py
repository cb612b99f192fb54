"""Paths of a live session's results, and free file names for each of its drives."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tierod.core.errors import TierodError
from tierod.live.engine import Engine
from tierod.live.events import Hub
from tierod.live.judge import Plan
from tierod.live.log import FrameLog, is_unfinished


@dataclass(frozen=True)
class Outputs:
    """Paths of a session's results.

    Args:
        log: MF4 file of all frames; "-2" is appended to the name for the second drive
        report: HTML page at the end of a drive
        silence: time without a frame after which the drive has ended; infinite for a single drive
        ignition: column of the databases ("Message.Signal") whose zero ends the drive; "" for none
        width: bytes of a payload in the log
    """

    log: Path | None = None
    report: Path | None = None
    silence: Annotated[float, "s"] = 30.0
    ignition: str = ""
    width: int = 8


class Logs:
    """Opens the logs of successive drives, each under a name of its own.

    Args:
        outputs: paths of the first drive
        plan: settings of the session
        hub: receives problems with a log
    """

    def __init__(self, outputs: Outputs, plan: Plan, hub: Hub):
        self._outputs, self._plan, self._hub = outputs, plan, hub
        self.path: Path | None = None

    def begin(self, engine: Engine, drives: int) -> None:
        """Open the logs of a drive, once the origin of its clock is set.

        Args:
            engine: engine of the drive
            drives: number of drives that have ended
        """
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
    """Call a function, and report an error of tierod as a problem instead of raising it.

    Args:
        hub: receives the problem
        work: function that may raise errors of tierod
    """
    try:
        work()
    except TierodError as error:
        hub.say("problem", {"text": str(error)})
