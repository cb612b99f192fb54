"""Conclusion of a drive that a killed program left and that is too old to be resumed, when the next session begins."""

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
    """Write fault memory, baselines and page of the interrupted drive, as at the end of any other.

    Args:
        engine: a new engine
        checkpoints: checkpoints that hold the drive
        plan: settings of the session
        outputs: names of the files; "-cut-off" is appended to the name of the page
        origin: provenance printed on the page; None writes no page
        hub: receives the outcome of each part

    Returns:
        the log of that drive; None where its checkpoint does not fit this program
    """
    log = checkpoints.conclude(engine)
    if log is None:
        return None
    finished = [Finished(*each) for each in engine.finish()]
    path = outputs.report
    report = path if path is None else path.with_name(f"{path.stem}-cut-off{path.suffix}")
    Closing(plan, report, log, origin, hub).write(engine, finished)
    # No state of it is resumed, since the car may have been driven in the meantime.
    guarded(hub, checkpoints.forget)
    return log
