"""Processes that are kept from part to part of the study: each reads in its modules and its kernels once."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from tierod.core.errors import InputError
from tierod.experiments.workers import Failure, Workers

_kept: list[Workers] = []


class _Task(NamedTuple):
    work: Callable[[Any], Any]
    given: Any


def _do(task: _Task) -> Any:
    return task.work(task.given)


@contextmanager
def kept() -> Iterator[None]:
    """Keep the processes of `in_processes` until its end."""
    with Workers(_do, 1) as workers:
        _kept.append(workers)
        try:
            yield
        finally:
            _kept.remove(workers)


def in_processes(
    work: Callable[[Any], Any],
    given: Sequence[Any],
    processes: int | None,
    what: Callable[[Any], str] = lambda task: f"a drive of the study ({task})",
) -> list[Any]:
    """What a function makes of everything given, in its order.

    Args:
        work: importable function of one of them, with picklable results
        given: picklable
        processes: how many work at a time; one per core if None; 1 is this process
        what: names one of them, for the message of a failure

    Raises:
        InputError: one failed, with the reason
    """
    processes = min(processes or os.cpu_count() or 1, len(given))
    if processes <= 1:
        return [work(each) for each in given]
    if not _kept:
        with kept():
            return in_processes(work, given, processes, what)
    workers, results = _kept[-1], {}
    workers.processes = max(workers.processes, processes)
    for number, result in workers.run([_Task(work, each) for each in given]):
        if isinstance(result, Failure):
            raise InputError(f"{what(given[number])} failed: {result.reason}")
        results[number] = result
    return [results[number] for number in range(len(given))]
