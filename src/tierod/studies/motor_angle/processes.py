"""Work on many drives at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

from tierod.campaigns.workers import Failure, spread
from tierod.errors import TierodError


def in_processes(work: Callable[[Any], Any], tasks: Sequence[Any], processes: int | None = 1) -> list[Any]:
    """What became of every task, in order.

    Args:
        work: importable function of one task
        tasks: picklable
        processes: that work at a time; one per core if None

    Raises:
        TierodError: a task failed
    """
    at_a_time = min(processes or os.cpu_count() or 1, len(tasks))
    if at_a_time <= 1:
        return [work(task) for task in tasks]
    found = dict(spread(work, tasks, at_a_time))
    for each in found.values():
        if isinstance(each, Failure):
            raise TierodError(f"a drive of the study failed: {each.reason}")
    return [found[number] for number in range(len(tasks))]
