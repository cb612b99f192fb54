"""Execution of tasks in worker processes; a cluster implements the same interface.

Guarantees: a crash of a process costs one task, no process outlives its parent, Ctrl-C and a full disk end the run at
once, and nothing hangs. Two libraries were tested against these guarantees (November 2026). With loky 3.7 one crash
fails every open task (`TerminatedWorkerError`). With pebble 5.2 a crash costs one task, but a run hangs if processes
are killed at random instants: the lock of the pipe that all its workers share is lost with the process that holds it.
Here every process has its own pipe, and the same test ends with one lost task per killed process.
"""

from __future__ import annotations

import os
import signal
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Protocol, TypeVar

from tierod.core.errors import (
    CompileError,
    KernelWarning,
    MissingExtra,
    OutputError,
    ParameterError,
    TierodError,
    lacks_memory,
)
from tierod.core.processes import THREADS, environment, safe_path

Given = TypeVar("Given")
Result = TypeVar("Result")
Work = Callable[[Any], Any]  # Importable function of one task; task and result must be picklable


@dataclass(frozen=True)
class Failure:
    """A task without a result."""

    reason: str  # reason in words
    lasting: bool  # whether the same task would fail again; false after a crash, or if something was not installed


class Passing(TierodError):
    """A failure that need not recur in another run."""


def run(
    work: Callable[[Given], Result], tasks: Sequence[Given], workers: int
) -> Iterator[tuple[int, Result | Failure]]:
    """(number of the task, result or Failure) of a batch of tasks, in the order of their completion."""
    with Executor(workers) as executor:
        yield from executor.run(work, tasks)


class Workers(Protocol):
    """Interface of the executors of tasks: processes of this machine, or a cluster; a context manager."""

    def __enter__(self) -> Workers: ...

    def __exit__(self, *_: object) -> None: ...

    def start(self, work: Work, count: int) -> None:
        """Let the workers for a number of tasks start in the background."""

    def run(self, work: Callable[[Given], Result], tasks: Sequence[Given]) -> Iterator[tuple[int, Result | Failure]]:
        """(number of the task, result or Failure) of every task, as in `Executor.run`."""


class Executor:
    """Processes that are kept from one batch of tasks to the next, as a context manager."""

    def __init__(self, workers: int):
        self.workers = workers
        self.context = get_context("spawn")
        self.processes: dict[Connection, BaseProcess] = {}
        self.busy: dict[Connection, int] = {}
        self.starting: set[Connection] = set()

    def __enter__(self) -> Executor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def start(self, work: Work, count: int) -> None:
        """Start processes for a number of tasks, up to the maximum; they import the work's module in the background."""
        for _ in range(min(self.workers, count) - len(self.processes)):
            self._start(work)

    def run(self, work: Callable[[Given], Result], tasks: Sequence[Given]) -> Iterator[tuple[int, Result | Failure]]:
        """(number of the task, result or Failure) of every task, in the order of their completion.

        Args:
            work: function of one task; OSError and OutputError are raised here too, all other exceptions become a
                Failure
        """
        waiting = ((number, (work, task)) for number, task in enumerate(tasks))
        self.start(work, len(tasks))
        for connection in list(self.processes):
            self._give(connection, waiting)
        try:
            while self.busy:
                for each in wait(list(self.busy)):
                    assert isinstance(each, Connection)
                    if (answer := self._answer(each)) is None:
                        continue
                    self._give(each if each in self.processes else self._start(work), waiting)
                    yield answer
        finally:
            self._stop(set(self.busy))  # their results are no longer needed

    def _answer(self, connection: Connection) -> tuple[int, Any] | None:
        """(number of the task, its outcome); None for the message of a process that it has started."""
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

    def _start(self, work: Work) -> Connection:
        ours, theirs = self.context.Pipe()
        # The work is an argument, so that the new process imports its module before it reports that it has started.
        process = self.context.Process(target=_serve, args=(theirs, work), daemon=True)
        with environment(dict.fromkeys(THREADS, "1")), safe_path():
            process.start()
        theirs.close()
        self.processes[ours] = process
        self.starting.add(ours)
        return ours

    def _give(self, connection: Connection, waiting: Iterator[tuple[int, tuple[Work, object]]]) -> None:
        task = next(waiting, None)
        if task is not None:
            self.busy[connection] = task[0]
            with suppress(BrokenPipeError):  # the process has died, which is detected when its answer is read
                connection.send(task[1])

    def _bury(self, connection: Connection) -> Failure:
        process = self.processes.pop(connection)
        process.join()
        connection.close()
        code = process.exitcode or 0
        if connection in self.starting and code > 0:
            raise ParameterError(
                "the worker processes cannot start; where a script of your own calls this, guard it with "
                "if __name__ == '__main__':, since every process imports the script"
            )
        how = f"was ended by signal {-code} ({signal.strsignal(-code)})" if code < 0 else f"ended with code {code}"
        return Failure(f"the process {how}; if memory was short, run with fewer --workers", lasting=False)

    def close(self) -> None:
        """Terminate processes that work; the others end when they detect that their connection is closed."""
        self._stop(set(self.processes))

    def _stop(self, connections: set[Connection]) -> None:
        stopped = [(connection, self.processes.pop(connection)) for connection in connections]
        for connection, process in stopped:
            if self.busy.pop(connection, None) is not None:
                process.terminate()
            self.starting.discard(connection)
            connection.close()
        for _, process in stopped:
            process.join()


def _serve(connection: Connection, _imported: Work) -> None:
    """Main loop of a worker: one task after another, until the parent closes its end of the pipe or ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes; the parent decides
    threading.Thread(target=_end_with_parent, daemon=True).start()
    warnings.simplefilter("ignore", KernelWarning)  # the parent, which compiles first, has already warned
    with suppress(EOFError, OSError):
        connection.send("ready")
        while True:
            connection.send(done(*connection.recv()))


def _end_with_parent() -> None:
    """End the process even during a task when its parent ends; no file stays incomplete, since files are renamed."""
    if (parent := parent_process()) is not None:
        parent.join()
        os._exit(1)


def done(work: Callable[[Given], Result], task: Given) -> Result | Failure | OSError | OutputError:
    try:
        return work(task)
    except (OSError, OutputError) as error:
        return error
    except TierodError as error:
        passing = isinstance(error, CompileError | MissingExtra | Passing)
        return Failure(" ".join(str(error).split()), lasting=not passing)
    except Exception as error:
        if lacks_memory(error):
            return Failure("the memory was not enough; run with fewer --workers", lasting=False)
        reason = f"a defect of tierod itself: {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        return Failure(reason, lasting=True)


def cores() -> int:
    """Number of processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
