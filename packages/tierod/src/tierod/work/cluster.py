"""Execution of tasks on a Dask cluster, with the same interface as on processes of this machine.

The cluster belongs to the user: nothing is installed, restarted or configured there. Each task makes the settings that
its worker needs. `MALLOC_TRIM_THRESHOLD_`, which Dask's nanny sets, fixes glibc's threshold for large blocks at 128 kB,
so that every array is mapped and unmapped: `diagnose` took 1.6 times as long (1 050 against 648 ms per hour).
"""

from __future__ import annotations

import contextlib
import ctypes
import queue
import threading
import time
import uuid
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from typing import Annotated, Any

from tierod.core.errors import KernelWarning, MissingExtra, OutputError, ParameterError
from tierod.core.version import __version__
from tierod.work.fingerprint import installed_code
from tierod.work.pool import Executor, Failure, Given, Result, Work, Workers, cores, done

# Size from which glibc maps a block [bytes]; smaller blocks come from memory that the process already has
MMAP_THRESHOLD = 32 * 1024**2

_M_MMAP_THRESHOLD = -3  # Number of this setting in malloc.h
PATIENCE: Annotated[float, "s"] = 15.0  # Timeout of the scheduler

# Time without workers after which a run ends; a nanny restarts a lost worker within seconds
WITHOUT_WORKERS: Annotated[float, "s"] = 60.0

LOOK: Annotated[float, "s"] = 1.0  # Polling interval of the state of the cluster

_alone = threading.Lock()  # Lock of a worker process: only one thread runs kernels at a time, whatever `--nthreads` is


class Cluster:
    """The workers of a Dask scheduler, as a context manager.

    Args:
        count: number of tasks submitted at a time; if None twice the number of workers, so that none waits
    """

    def __init__(self, address: str, count: int | None = None):
        self.address, self.count = address, count
        self._client: Any = None

    def __enter__(self) -> Cluster:
        try:
            from distributed import Client
        except ImportError:
            raise MissingExtra("distributed", "fleet", "a Dask cluster") from None
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # relevant mismatches of versions are found by `_refuse_strangers`
                self._client = Client(self.address, timeout=PATIENCE, set_as_default=False)  # type: ignore[no-untyped-call]
            self._refuse_strangers()
        except BaseException as error:
            self.close()
            if isinstance(error, ParameterError) or not isinstance(error, Exception):
                raise
            reason = " ".join(str(error).split())[:160] or type(error).__name__
            raise ParameterError(
                f"the Dask scheduler {self.address} does not answer ({reason}); check the address with --scheduler, "
                "and that it runs a version of 'distributed' near this one"
            ) from None
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Disconnect, and leave the cluster running."""
        if self._client is not None:
            with contextlib.suppress(Exception):
                self._client.close(timeout=2.0)
            self._client = None

    def start(self, work: Work, count: int) -> None:
        """Do nothing: the workers of a cluster already run."""

    def run(self, work: Callable[[Given], Result], tasks: Sequence[Given]) -> Iterator[tuple[int, Result | Failure]]:
        waiting = iter(enumerate(tasks))
        open_: dict[Any, int] = {}
        ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        watch = _Watch(self)
        try:
            self._fill(work, waiting, open_, ended, watch)
            while open_:
                try:
                    future = ended.get(timeout=LOOK)
                except queue.Empty:
                    watch.look()
                    continue
                number = open_.pop(future)
                result = self._result(future)
                self._fill(work, waiting, open_, ended, watch)
                if isinstance(result, OSError | OutputError):
                    raise result
                yield number, result
        finally:
            if open_ and self._client is not None:
                with contextlib.suppress(Exception):
                    self._client.cancel(list(open_))

    def _fill(self, work: Work, waiting: Iterator[tuple[int, Any]], open_: dict[Any, int],
              ended: queue.SimpleQueue[Any], watch: _Watch) -> None:  # fmt: skip
        while len(open_) < (self.count or 2 * watch.workers):
            each = next(waiting, None)
            if each is None:
                return
            # A unique key: results are identified by their content, never by an earlier result in the cluster's memory.
            future = self._client.submit(_done, work, each[1], key=f"tierod-{uuid.uuid4().hex}", pure=False)
            open_[future] = each[0]
            future.add_done_callback(ended.put)

    def _result(self, future: Any) -> Any:
        from distributed import KilledWorker

        if future.status == "finished":
            try:
                result = future.result(timeout=PATIENCE)
            except Exception as error:  # the scheduler was lost after the task had finished
                raise self._gone() from error
            future.release()
            return result
        if future.status == "error":
            failure = future.exception()
            if isinstance(failure, KilledWorker):
                return Failure("the workers that had it were lost; if memory was short, give them more", lasting=False)
            reason = " ".join(str(failure).split())[:200]
            return Failure(f"its worker could not run it: {type(failure).__name__}: {reason}", lasting=False)
        raise self._gone()

    def _gone(self) -> ParameterError:
        return ParameterError(
            f"the Dask scheduler {self.address} is gone; start it and run the same command again: what is finished is "
            "kept"
        )

    def _refuse_strangers(self) -> None:
        end = time.monotonic() + PATIENCE
        while not (workers := self._client.scheduler_info(n_workers=-1)["workers"]):
            if time.monotonic() > end:
                raise ParameterError(
                    f"the Dask scheduler {self.address} has no workers; start some with: dask worker {self.address}"
                )
            time.sleep(0.2)
        answers = self._client.run(_about, on_error="return")
        ours = _about()
        for worker in sorted(answers):
            if why := _stranger(answers[worker], ours):
                raise ParameterError(
                    f"{why} on the Dask worker {worker} ({len(workers)} in all); install tierod {__version__} there: "
                    "a result must not depend on which worker made it"
                )


class _Watch:
    def __init__(self, cluster: Cluster):
        self._cluster = cluster
        self._seen = time.monotonic()
        self._looked = 0.0
        self._count = 1

    @property
    def workers(self) -> int:
        if time.monotonic() - self._looked > LOOK:
            self.look()
        return self._count

    def look(self) -> None:
        client = self._cluster._client
        self._looked = now = time.monotonic()
        if client.status in ("closed", "closing"):
            raise self._cluster._gone()
        if client.status == "running":
            # The scheduler sends this information every two seconds anyway, so reading it costs no message.
            found = len(client.scheduler_info(n_workers=-1)["workers"])
            self._count = max(found, 1)
            if found:
                self._seen = now
        if now - self._seen > WITHOUT_WORKERS:
            raise ParameterError(
                f"the Dask cluster {self._cluster.address} has had no workers for {WITHOUT_WORKERS:g} s; start some "
                "and run the same command again: what is finished is kept"
            )


def _about() -> dict[str, str]:
    return {"version": __version__, "code": installed_code()}


def _stranger(answer: Any, ours: Mapping[str, str]) -> str:
    """Difference of a worker's tierod from this one, as a clause; "" if there is none."""
    if isinstance(answer, Mapping):
        if answer.get("version") != ours["version"]:
            return f"there is tierod {answer.get('version')}"
        return "" if answer.get("code") == ours["code"] else f"there is another tierod {ours['version']}, changed"
    if isinstance(answer, ImportError) or "No module named 'tierod" in str(answer):
        missing = "No module named 'tierod'" in str(answer) or getattr(answer, "name", "") == "tierod"
        return "there is no tierod" if missing else "there is a tierod that lacks a part"
    return f"tierod cannot be run ({' '.join(str(answer).split())[:120]})"


def _done(work: Callable[[Given], Result], task: Given) -> Any:
    """Executed by a worker: the result of a task, a Failure, or the error that ends the run."""
    _settle()
    with _alone, warnings.catch_warnings():
        warnings.simplefilter("ignore", KernelWarning)
        return done(work, task)


@cache
def _settle() -> None:
    """Let glibc keep freed memory, as `MALLOC_MMAP_THRESHOLD_=33554432` in the environment of a worker does."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).mallopt(_M_MMAP_THRESHOLD, MMAP_THRESHOLD)


def workers_of(count: int | None = None, scheduler: str | None = None) -> Workers:
    """Workers for tasks, not started yet.

    Args:
        count: processes of this machine; one per core if None. With a cluster, number of tasks submitted at a time;
            twice the number of workers if None
        scheduler: address of a Dask scheduler, as "tcp://host:8786"; None for processes of this machine
    """
    if scheduler is None:
        return Executor(count or cores())
    return Cluster(scheduler, count)
