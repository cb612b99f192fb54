"""Effort of a study and execution of its drives, each of which is simulated once and kept."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError
from tierod.core.graph.kernel_cache import Bounds, KernelCache
from tierod.work.cluster import workers_of
from tierod.work.fingerprint import fingerprint
from tierod.work.pool import Failure, Given, Passing, Result, Work, Workers, cores, run
from tierod_lab.campaign.code import work_code

Progress = Callable[[float, str], None]  # Called with the completed share (0 to 1) and a description of the next part

BOUNDS = Bounds(bytes=2 * 1024**3, count=65536)
"""Bounds of the kept results of studies: a full study has about 10 000, which take less than 200 MB."""


@dataclass(frozen=True)
class Effort:
    """Effort of a study, and the workers of its drives."""

    quick: bool = False  # a few minutes of driving only: a check that everything works, whose figures are no evidence
    processes: int | None = None  # worker processes; one per core if None
    thorough: bool = False  # additional hours of driving, for studies that count rare events
    # kept results of drives; None keeps nothing
    results: Results | None = field(default=None, compare=False, repr=False)
    # address of a Dask scheduler whose workers run the drives; None for processes of this machine
    scheduler: str | None = None
    # workers that are kept from part to part of a study; None starts new ones for every batch of drives, and runs a
    # single drive, or all of them with one process, in this process
    executor: Workers | None = field(default=None, compare=False, repr=False)

    @property
    def workers(self) -> int:
        """Number of processes."""
        return self.processes or cores()

    @contextmanager
    def kept(self, folder: Path | None) -> Iterator[Effort]:
        """The same effort, with workers until the end of the context, and with results in a folder."""
        count = self.workers if self.scheduler is None else self.processes
        with workers_of(count, self.scheduler) as executor:
            yield replace(self, executor=executor, results=Results(folder) if folder else None)

    def outcomes(
        self, work: Callable[[Given], Result], given: Sequence[Given]
    ) -> Iterator[tuple[int, Result | Failure]]:
        """(number, result or Failure) of every item: kept results first, then the others as they complete."""
        keys = [self.results.key(work, each) if self.results else "" for each in given]
        missing = []
        for number, key in enumerate(keys):
            found = self.results.find(key) if self.results else None
            if found is None:
                missing.append(number)
            else:
                yield number, found[0]
        tasks = [given[number] for number in missing]
        work = partial(_with_code, _code(work), work) if self.results else work
        for at, result in self._worked(work, tasks):
            if self.results and not isinstance(result, Failure):
                self.results.keep(keys[missing[at]], result)
            yield missing[at], result

    def _worked(
        self, work: Callable[[Given], Result], tasks: Sequence[Given]
    ) -> Iterator[tuple[int, Result | Failure]]:
        if self.executor:
            return self.executor.run(work, tasks)
        workers = min(self.workers, len(tasks))
        return run(work, tasks, workers) if workers > 1 else ((at, work(task)) for at, task in enumerate(tasks))

    def made(
        self,
        work: Callable[[Given], Result],
        given: Sequence[Given],
        what: Callable[[Given], str] = lambda each: f"a drive of the study ({each})",
    ) -> list[Result]:
        """The results of all items, in their order; arguments as in `outcomes`."""
        results: dict[int, Result] = {}
        for number, result in self.outcomes(work, given):
            if isinstance(result, Failure):
                raise InputError(f"{what(given[number])} failed: {result.reason}")
            results[number] = result
        return [results[number] for number in range(len(given))]


class Results:
    """Results of drives in a user's folder, each under the fingerprint of everything that determines it.

    Results are pickled. Like compiled kernels, they are read only from a folder that no other user can write, and
    verified by their digest; the least recently used ones are removed when there are too many.

    Args:
        folder: folder, created if absent
    """

    def __init__(self, folder: Path):
        self.cache = KernelCache(folder, BOUNDS)
        with suppress(OSError):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        self.usable = folder.is_dir() and os.access(folder, os.W_OK) and not self.cache.trouble()

    def key(self, work: Work, given: object) -> str:
        """Key of a task's result, from function, code and arguments; "" if an argument has no fingerprint."""
        try:
            return f"result-{fingerprint(work, given, _code(work))[:24]}"
        except TypeError:
            return ""

    def find(self, key: str) -> tuple[Any] | None:
        """The kept result as a tuple of one item; None if there is none or it is damaged."""
        content = self.cache.kept(key) if key and self.usable else None
        if content is not None:
            with suppress(Exception):  # written by another version of a library, for example: computed anew
                return (pickle.loads(content),)
        return None

    def keep(self, key: str, result: object) -> None:
        """Write a result atomically."""
        if key and self.usable:
            self.cache.keep(key, pickle.dumps(result))


def _code(work: Work) -> str:
    return work_code((work.func if isinstance(work, partial) else work).__module__)


def _with_code(code: str, work: Callable[[Given], Result], given: Given) -> Result:
    """Result of a task, if this process has the code of its key: the process may have started after a change of it."""
    if _code(work) != code:
        raise Passing("the code of tierod has changed since the study began; run it again")
    return work(given)
