"""Runs every drive that the parts of the study need, once and on all cores, reference drives first."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from tierod.core.errors import TierodError
from tierod.work.pool import Failure
from tierod_lab.papers.friction.cases import Case
from tierod_lab.papers.friction.digest import Digest, digest
from tierod_lab.studies.effort import Effort, Progress

Wants = Mapping[Case, Iterable[str]]  # Drive -> names of the estimators that run over it


@dataclass(frozen=True)
class _Task:
    case: Case
    names: tuple[str, ...]
    level: tuple[float, float] | None = None
    first: int = 0


@dataclass(frozen=True)
class Drives:
    """All drives of a study."""

    digests: Mapping[Case, Digest]  # digest of every drive that succeeded
    failures: tuple[tuple[Case, str], ...] = ()  # (drive, reason) of every drive that failed
    first: int = 0  # offset of the seeds of all drives

    def of(self, cases: Iterable[Case]) -> list[Digest]:
        """Digests of the given drives in their order, without those that failed."""
        return [self.digests[case] for case in cases if case in self.digests]

    @property
    def hours(self) -> float:
        """Total duration of the drives [h]."""
        return sum(each.seconds for each in self.digests.values()) / 3600.0


def run_drives(parts: Iterable[Wants], effort: Effort, progress: Progress, first: int = 0) -> Drives:
    """Runs every drive once, with all estimators that any part needs.

    Args:
        parts: drives and estimators that each part of the study needs
        effort: effort of the study, with the workers and kept results
        progress: called with the share of the driving done and a description

    Raises:
        TierodError: every drive failed
    """
    wants: dict[Case, set[str]] = {}
    for part in parts:
        for case, names in part.items():
            wants.setdefault(case, set()).update(names)
            if case.reference is not None:
                wants.setdefault(case.reference, set())
    minutes, done = sum(case.minutes for case in wants), 0.0
    digests: dict[Case, Digest] = {}
    failures: list[tuple[Case, str]] = []
    for alone in (True, False):
        cases = [case for case in wants if (case.reference is None) is alone]
        # The level of a reference is known only now, so the tasks of the second round are made here.
        tasks = [_Task(case, tuple(sorted(wants[case]))) for case in cases]
        given = [replace(_with_level(task, digests), first=first) for task in tasks]
        # Longest first, so that no core is left alone with a long drive at the end.
        given.sort(key=lambda task: -task.case.minutes)
        for number, result in effort.outcomes(_work, given):
            case = given[number].case
            if isinstance(result, Failure):
                failures.append((case, result.reason))
            else:
                digests[case] = result
            done += case.minutes
            progress(done / minutes, f"{len(wants)} drives, {minutes / 60.0:.1f} h")
    if wants and not digests:
        raise TierodError(f"no drive of the study went well; the first one ended so: {failures[0][1]}")
    return Drives(digests, tuple(failures), first)


def _with_level(task: _Task, digests: Mapping[Case, Digest]) -> _Task:
    known = digests.get(task.case.reference) if task.case.reference is not None else None
    level = known.verdict.level if known is not None and known.verdict is not None else None
    return replace(task, level=level)


def _work(task: _Task) -> Digest:
    return digest(task.case.counted_from(task.first), task.names, task.level)
