"""Selection of the executor: processes of this machine, or a Dask cluster by its address."""

from __future__ import annotations

import os

from tierod.work.executor import Executor, Workers


def cores() -> int:
    """Number of processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def workers_of(count: int | None = None, scheduler: str | None = None) -> Workers:
    """Workers for tasks, not started yet.

    Args:
        count: processes of this machine; one per core if None. With a cluster, number of tasks submitted at a time;
            twice the number of workers if None
        scheduler: address of a Dask scheduler, as "tcp://host:8786"; None for processes of this machine

    Raises:
        ParameterError: the scheduler does not answer, or its workers have another tierod
        MissingExtra: `distributed` is not installed
    """
    if scheduler is None:
        return Executor(count or cores())
    from tierod.work.cluster import Cluster

    return Cluster(scheduler, count)
