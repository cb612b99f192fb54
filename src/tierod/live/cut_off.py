"""A drive that a killed program left, and that is too old to go on: it is concluded when the next session begins."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from tierod.live.closing import Closing, Finished
from tierod.live.engine import Engine
from tierod.live.events import Hub
from tierod.live.judge import Plan
from tierod.live.outputs import Outputs, guarded
from tierod.live.resuming import Checkpoints

if TYPE_CHECKING:
    from tierod.report.html import Origin


def conclude_cut_off(
    engine: Engine,
    checkpoints: Checkpoints,
    plan: Plan,
    outputs: Outputs,
    origin: Callable[[], Origin] | None,
    hub: Hub,
) -> Path | None:
    """Write fault memory, baselines and page of that drive, as at the end of any other.

    Args:
        engine: new
        checkpoints: that hold the drive
        plan: of the session
        outputs: names of the files; its page gets "-cut-off" behind its name
        origin: of the page; None writes none
        hub: takes what became of each part

    Returns:
        the log of that drive; None where it does not fit this program
    """
    log = checkpoints.conclude(engine)
    if log is None:
        return None
    finished = [Finished(*each) for each in engine.finish()]
    path = outputs.report
    report = path if path is None else path.with_name(f"{path.stem}-cut-off{path.suffix}")
    Closing(plan, report, log, origin, hub).write(engine, finished)
    # Nothing of it goes on: the car may have been driven since.
    guarded(hub, checkpoints.forget)
    return log
