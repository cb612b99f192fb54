"""Processes that are kept from part to part of the study: each reads in its modules and its kernels once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from tierod.campaigns.workers import Failure, Workers
from tierod.errors import InputError

_kept: list[Workers] = []


class _Task(NamedTuple):
    work: Callable[[Any], Any]
    given: Any


def _do(task: _Task) -> Any:
    return task.work(task.given)


@contextmanager
def kept() -> Iterator[None]:
    """Keep the processes of `all_done` until its end."""
    with Workers(_do, 1) as workers:
        _kept.append(workers)
        try:
            yield
        finally:
            _kept.remove(workers)


def all_done(work: Callable[[Any], Any], given: Sequence[Any], processes: int, what: Callable[[Any], str]) -> list[Any]:
    """What a function makes of everything given, in its order.

    Args:
        work: importable function of one of them, with picklable results
        given: picklable
        processes: how many work at a time; 1 is this process
        what: names one of them, for the message of a failure

    Raises:
        InputError: one failed; the reason is told
    """
    if processes <= 1:
        return [work(each) for each in given]
    if not _kept:
        with kept():
            return all_done(work, given, processes, what)
    workers, results = _kept[-1], {}
    workers.processes = max(workers.processes, processes)
    for number, result in workers.run([_Task(work, each) for each in given]):
        if isinstance(result, Failure):
            raise InputError(f"{what(given[number])} failed: {result.reason}")
        results[number] = result
    return [results[number] for number in range(len(given))]
