"""Effort of a study, and its requested drives: each a cell that is driven once and kept."""

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
from tierod.experiments.doors import workers_of
from tierod.experiments.executor import Failure, Given, Passing, Result, Work, Workers, run
from tierod.experiments.fingerprint import fingerprint, work_code

Progress = Callable[[float, str], None]
"""Called with the share done (0 to 1) and what comes next."""

BOUNDS = Bounds(bytes=2 * 1024**3, count=65536)
"""Of the kept results of studies: those of one full study are some 10 000 and take less than 200 MB."""


@dataclass(frozen=True)
class Effort:
    """Effort that is put into a study, and what makes its drives.

    Args:
        quick: a few minutes of driving only: a check that everything works, its figures are no evidence
        processes: worker processes; one per core if None
        thorough: hours of driving more, where a study counts what is rare
        results: results of drives that are kept from run to run; None keeps nothing
        scheduler: address of a Dask scheduler whose workers make the drives; None for processes of this machine
        executor: workers that are kept from part to part of a study; None starts new ones for every lot of drives,
            and makes a single drive, or all where one process is wanted, in this process
    """

    quick: bool = False
    processes: int | None = None
    thorough: bool = False
    results: Results | None = field(default=None, compare=False, repr=False)
    scheduler: str | None = None
    executor: Workers | None = field(default=None, compare=False, repr=False)

    @property
    def workers(self) -> int:
        """Number of processes that work at a time."""
        return self.processes or os.cpu_count() or 1

    @contextmanager
    def kept(self, folder: Path | None) -> Iterator[Effort]:
        """The same effort, whose processes live until the end of the context and whose results are kept in a folder.

        Args:
            folder: made where it is absent; None keeps no results
        """
        count = self.workers if self.scheduler is None else self.processes
        with workers_of(count, self.scheduler) as executor:
            yield replace(self, executor=executor, results=Results(folder) if folder else None)

    def outcomes(
        self, work: Callable[[Given], Result], given: Sequence[Given]
    ) -> Iterator[tuple[int, Result | Failure]]:
        """(number, result or Failure) of everything given: what is kept first, then the rest as it ends.

        Args:
            work: importable function of one of them, with picklable results, or a partial of one
            given: picklable, in the order in which they are started

        Raises:
            OSError, OutputError: as a task raised it, or a result cannot be kept (a full disk, for example)
        """
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
        """The results of everything given, in its order; arguments as of `outcomes`.

        Args:
            what: names one of them, for the message of a failure

        Raises:
            InputError: one failed, with the reason
            OSError, OutputError: as of `outcomes`
        """
        results: dict[int, Result] = {}
        for number, result in self.outcomes(work, given):
            if isinstance(result, Failure):
                raise InputError(f"{what(given[number])} failed: {result.reason}")
            results[number] = result
        return [results[number] for number in range(len(given))]


class Results:
    """Results of drives in a folder of the user's own, each under the fingerprint of all that decides it.

    A result is pickled. Like compiled kernels, results are read only from a folder that no other user can write, each
    verified by its digest; the least recently used ones go first where there are too many.

    Args:
        folder: made where it is absent
    """

    def __init__(self, folder: Path):
        self.cache = KernelCache(folder, BOUNDS)
        with suppress(OSError):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        self.usable = folder.is_dir() and os.access(folder, os.W_OK) and not self.cache.trouble()

    def key(self, work: Work, given: object) -> str:
        """Key of a task's result, from function, code and arguments; "" where an argument has no content."""
        try:
            return f"result-{fingerprint(work, given, _code(work))[:24]}"
        except TypeError:
            return ""

    def find(self, key: str) -> tuple[Any] | None:
        """(the result,) if a whole one is kept."""
        content = self.cache.kept(key) if key and self.usable else None
        if content is not None:
            with suppress(Exception):  # written by another version of a library, for example: made anew
                return (pickle.loads(content),)
        return None

    def keep(self, key: str, result: object) -> None:
        """Write a result, whole or not at all.

        Raises:
            OutputError: it cannot be written
        """
        if key and self.usable:
            self.cache.keep(key, pickle.dumps(result))


def _code(work: Work) -> str:
    return work_code((work.func if isinstance(work, partial) else work).__module__)


def _with_code(code: str, work: Callable[[Given], Result], given: Given) -> Result:
    """The result of a task, from the code that it is kept for: this process may have been started after a change."""
    if _code(work) != code:
        raise Passing("the code of tierod has changed since the study began; run it again")
    return work(given)
