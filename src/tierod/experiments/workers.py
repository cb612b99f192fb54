"""Processes that work on tasks, each on one at a time: a crash costs one task, and no process outlives its parent."""

from __future__ import annotations

import os
import signal
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from typing import Any

from tierod.core.errors import CompileError, KernelWarning, MissingExtra, OutputError, ParameterError, TierodError

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Set to one in the workers: they share the cores already, and sums would depend on the number of threads."""


LOOK_PERIOD = 0.5
"""Seconds between two looks whether the parent is there."""

_looked = 0.0


@dataclass(frozen=True)
class Failure:
    """A task that gave no result.

    Args:
        reason: in words
        lasting: whether the same task would fail again; not so after a crash, or where something was not installed
        detail: traceback, if there is one
    """

    reason: str
    lasting: bool
    detail: str = ""


class Passing(TierodError):
    """A failure that another run may not meet."""


class Orphaned(Exception):
    """The parent process is gone, so nobody waits for the result."""


def stop_if_orphaned() -> None:
    """Raise where the process that gave the task out is gone; to be called now and then during a long task.

    Raises:
        Orphaned: it is gone
    """
    global _looked
    if (parent := parent_process()) is None or time.monotonic() - _looked < LOOK_PERIOD:
        return
    _looked = time.monotonic()
    if not parent.is_alive():
        raise Orphaned


def spread(work: Callable[[Any], Any], tasks: Sequence[Any], processes: int) -> Iterator[tuple[int, Any]]:
    """(number of the task, result or Failure) of one lot of tasks; arguments and errors as of `Workers`."""
    with Workers(work, processes) as workers:
        yield from workers.run(tasks)


class Workers:
    """Processes that are kept from one lot of tasks to the next; a context.

    Args:
        work: importable function of one task; OSError and OutputError are raised here too, all other exceptions make a
            Failure
        processes: how many work at a time
    """

    def __init__(self, work: Callable[[Any], Any], processes: int):
        self.work, self.processes = work, processes
        self.context = get_context("spawn")
        self.workers: dict[Connection, Any] = {}
        self.busy: dict[Connection, int] = {}
        self.starting: set[Connection] = set()

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def start(self, count: int) -> None:
        """Let so many processes start, as far as allowed; they read in their modules while other things are done."""
        for _ in range(min(self.processes, count) - len(self.workers)):
            self._start()

    def run(self, tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """(number of the task, result or Failure) of every task, in the order in which they end.

        Args:
            tasks: picklable; started in their order

        Raises:
            OSError, OutputError: as a task raised it (a full disk, for example)
            ParameterError: the processes cannot start
        """
        waiting = iter(enumerate(tasks))
        self.start(len(tasks))
        for connection in list(self.workers):
            self._give(connection, waiting)
        while self.busy:
            for each in wait(list(self.busy)):
                assert isinstance(each, Connection)
                if (answer := self._answer(each)) is None:
                    continue
                number, result = answer
                self._give(each if each in self.workers else self._start(), waiting)
                yield number, result

    def _answer(self, connection: Connection) -> tuple[int, Any] | None:
        """(number of the task, what became of it); None where a process only says that it has started."""
        try:
            result = connection.recv()
        except (EOFError, OSError):
            return self.busy.pop(connection), self._bury(connection)
        if connection in self.starting:
            self.starting.remove(connection)
            return None
        if isinstance(result, OSError | OutputError):
            raise result
        return self.busy.pop(connection), result

    def _start(self) -> Connection:
        ours, theirs = self.context.Pipe()
        process = self.context.Process(target=_serve, args=(theirs, self.work), daemon=True)
        with _one_thread():
            process.start()
        theirs.close()
        self.workers[ours] = process
        self.starting.add(ours)
        return ours

    def _give(self, connection: Connection, waiting: Iterator[tuple[int, Any]]) -> None:
        task = next(waiting, None)
        if task is not None:
            self.busy[connection] = task[0]
            with suppress(BrokenPipeError):  # the process has died already, which is seen when its answer is read
                connection.send(task[1])

    def _bury(self, connection: Connection) -> Failure:
        process = self.workers.pop(connection)
        process.join()
        connection.close()
        code = process.exitcode
        if connection in self.starting and code > 0:
            raise ParameterError(
                "the worker processes cannot start; where a script of your own calls this, guard it with "
                "if __name__ == '__main__':, since every process imports the script"
            )
        how = f"was ended by signal {-code} ({signal.strsignal(-code)})" if code < 0 else f"ended with code {code}"
        return Failure(f"the process {how}; if memory was short, run with fewer --workers", lasting=False)

    def close(self) -> None:
        """End all processes; those at work at once, the others when they see that nobody asks any more."""
        for connection, process in self.workers.items():
            if connection in self.busy:
                process.terminate()
            connection.close()
        for process in self.workers.values():
            process.join()
        self.workers.clear()
        self.busy.clear()


@contextmanager
def _one_thread() -> Iterator[None]:
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _serve(connection: Connection, work: Callable[[Any], Any]) -> None:
    """What a worker does: one task after the other, until the parent closes its end or is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes; the parent decides
    warnings.simplefilter("ignore", KernelWarning)  # the parent, which compiles first, has said it
    with suppress(EOFError, OSError, Orphaned):
        connection.send("ready")
        while True:
            connection.send(_done(work, connection.recv()))


def _done(work: Callable[[Any], Any], task: Any) -> Any:
    try:
        return work(task)
    except Orphaned:
        raise
    except (OSError, OutputError) as error:
        return error
    except MemoryError:
        return Failure("the memory was not enough; run with fewer --workers", lasting=False)
    except TierodError as error:
        passing = isinstance(error, CompileError | MissingExtra | Passing)
        return Failure(" ".join(str(error).split()), lasting=not passing)
    except Exception as error:
        reason = f"a defect of tierod itself: {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        return Failure(reason, lasting=True, detail=traceback.format_exc())
