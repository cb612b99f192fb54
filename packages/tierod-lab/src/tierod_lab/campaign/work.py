"""Processing of one cell by a worker: simulate the drive, keep it, and judge it by every monitor."""

from __future__ import annotations

import dataclasses
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any

from tierod.core.errors import CompileError, MissingExtra, OutputError, TierodError
from tierod.core.recording import Recording
from tierod.core.version import __version__
from tierod.monitors.harness.baseline import Baseline
from tierod.work.pool import Passing
from tierod_lab.campaign.code import ground_code, judging_code
from tierod_lab.campaign.judged import Window, plain
from tierod_lab.campaign.judging import judge
from tierod_lab.campaign.plan import Cell, Judge, window_of
from tierod_lab.campaign.store import Store

if TYPE_CHECKING:
    from tierod_lab.ground.scenarios import Scenario

DRIVEN, DIVERGED, FAILED = "driven", "diverged", "failed"
"""Outcomes of a drive."""


@dataclass(frozen=True)
class Reference:
    """Baseline for a verdict.

    Args:
        level: baseline from another drive; None if the monitor learns its own
        refusal: reason why a required baseline is missing; "" otherwise
        lasting: whether it would be missing again
    """

    level: Baseline | None = None
    refusal: str = ""
    lasting: bool = True


@dataclass(frozen=True)
class Verdict:
    """One verdict to be made."""

    judge: Judge
    name: str
    key: str
    reference: Reference = field(default_factory=Reference)


@dataclass(frozen=True)
class Task:
    """Work on one cell.

    Args:
        settling: see `tierod_lab.campaign.definition.CampaignFile`
        code: digests of tierod's code at the start of the campaign
    """

    store: Store
    cell: Cell
    verdicts: tuple[Verdict, ...]
    settling: float
    keep: bool
    code: tuple[str, str]


def work(task: Task) -> str:
    """Process a task, and return the outcome of its drive."""
    if task.code != code():
        raise Passing("the code of tierod has changed since the campaign began; run it again")
    drive, recording = _driven(task)
    if drive["outcome"] == DRIVEN:
        fault = window_of(drive["windows"])
        for verdict in task.verdicts:
            record = _judged(task, verdict, recording, fault)
            task.store.keep_verdict(verdict.name, verdict.key, record)
    return str(drive["outcome"])


def code() -> tuple[str, str]:
    """Digests of the code for drives and of the code for verdicts."""
    return ground_code(), judging_code()


def _driven(task: Task) -> tuple[Mapping[str, Any], Recording]:
    store, cell = task.store, task.cell
    kept = store.drive(cell.name, cell.key)
    if kept is not None and (recording := store.recording(kept)) is not None:
        return kept, recording
    outcome = cell.scenario.run()
    at = outcome.diverged_at
    record = {
        "outcome": DRIVEN if at is None else DIVERGED,
        "reason": "" if at is None else f"the run did not stay within its limits; its last good time is {at:.6g} s",
        "last_good_s": at,
        "lasting": True,
        "place": dict(cell.point.place),
        "windows": [_plain(window) for window in outcome.windows],
        "recording": store.keep_recording(cell.name, cell.key, outcome.recording) if task.keep else None,
        "provenance": provenance(cell.scenario),
    }
    store.keep_drive(cell.name, cell.key, record)
    return record, outcome.recording


def failed(cell: Cell, reason: str, lasting: bool) -> dict[str, Any]:
    """Record of a drive without a recording."""
    return {
        "outcome": FAILED,
        "reason": reason,
        "last_good_s": None,
        "lasting": lasting,
        "place": dict(cell.point.place),
        "windows": [],
        "recording": None,
        "provenance": provenance(cell.scenario),
    }


def _judged(task: Task, verdict: Verdict, recording: Recording, fault: Window | None) -> dict[str, Any]:
    """Record of a verdict; if it cannot be made, with the reason."""
    record: dict[str, Any] = {"monitor": verdict.judge.label, "drive": task.cell.key, "judged": None, "baseline": None}
    if verdict.reference.refusal:
        return record | {"reason": verdict.reference.refusal, "lasting": verdict.reference.lasting}
    chosen = verdict.judge
    try:
        judged, learnt = judge(recording, chosen.found(), chosen.belief, verdict.reference.level, fault, task.settling)
    except OutputError:
        raise
    except TierodError as error:
        reason = " ".join(str(error).split())
        return record | {"reason": reason, "lasting": not isinstance(error, CompileError | MissingExtra)}
    except (ArithmeticError, LookupError, RuntimeError, TypeError, ValueError) as error:
        text = f"a defect of tierod itself: {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        return record | {"reason": text, "lasting": True}
    own = None if learnt is None else dataclasses.asdict(learnt)
    return record | {"reason": "", "lasting": True, "judged": plain(judged), "baseline": own}


def provenance(scenario: Scenario) -> dict[str, Any]:
    """Provenance of a drive: the complete scenario, tierod's version, and the machine."""
    return {"scenario": _plain(scenario.provenance), **_machine()}


@cache
def _machine() -> dict[str, Any]:
    import numpy

    from tierod.core.graph.compiler import compiler
    from tierod.core.graph.kernel import is_interpreted

    command = compiler()
    return {
        "version": __version__,
        "python": platform.python_version(),
        "numpy": numpy.__version__,
        "platform": platform.platform(),
        "compiler": "virtual machine" if is_interpreted() or command is None else " ".join(command),
    }


def _plain(value: object) -> Any:
    """The value as plain JSON; unknown types become text."""
    import json

    return json.loads(json.dumps(_finite(value), default=str, allow_nan=False))


def _finite(value: object) -> Any:
    import math

    if isinstance(value, Mapping):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    return repr(value) if isinstance(value, float) and not math.isfinite(value) else value
