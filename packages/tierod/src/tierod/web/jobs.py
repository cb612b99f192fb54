"""Jobs in processes of their own: a queue, progress, cancelling, and limits of time and memory.

`tierod.work.pool` runs many tasks to their end; here each job has its own process, so that it can be cancelled, or
exceed its limits, without an effect on the others. One process per thread waits ready, with all modules imported.
"""

from __future__ import annotations

import signal
import threading
import time
import uuid
import warnings
from collections import OrderedDict, deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from tierod.core.errors import KernelWarning, OutputError, ParameterError
from tierod.core.processes import safe_path
from tierod.web.errors import Absent, Busy, in_the_page
from tierod.web.site import Limits
from tierod.work.pool import Failure, done

KEPT = 500  # Number of finished jobs that are kept in the list

LOOK = 0.2  # Polling interval for the cancelling and the time limit of a running job [s]

WAITING, RUNNING, DONE, FAILED, CANCELLED = "waiting", "running", "done", "failed", "cancelled"


@dataclass
class Job:
    """One piece of work."""

    id: str
    kind: str
    given: dict[str, Any]
    about: str
    state: str = WAITING  # waiting, running, done, failed or cancelled
    share: float = 0.0
    text: str = ""  # current step, or why it failed
    found: dict[str, Any] = field(default_factory=dict)  # results available so far; the complete result after the end
    created: float = field(default_factory=time.time)

    @property
    def ended(self) -> bool:
        return self.state in (DONE, FAILED, CANCELLED)


class Jobs:
    """Queue of jobs; `close` ends all.

    Args:
        limits: limits of every job and of the queue
    """

    def __init__(self, workers: int, limits: Limits, finished: Callable[[Job], None] = lambda job: None):
        self.limits, self._finished = limits, finished
        self._jobs: OrderedDict[str, Job] = OrderedDict()
        self._queue: deque[Job] = deque()
        self._changed = threading.Condition()
        self._closed = False
        self._context = get_context("spawn")
        self._spare: list[tuple[BaseProcess, Connection]] = []
        self._threads = [threading.Thread(target=self._work, daemon=True) for _ in range(workers)]
        for thread in self._threads:
            thread.start()

    def submit(self, kind: str, given: dict[str, Any], about: str) -> Job:
        """Add a job to the queue; an equal job that waits or runs already is returned instead."""
        with self._changed:
            for job in self._jobs.values():
                if not job.ended and (job.kind, job.given) == (kind, given):
                    return job
            if len(self._queue) >= self.limits.waiting:
                raise Busy(f"{len(self._queue)} jobs wait already; cancel some, or wait until they are done")
            job = Job(uuid.uuid4().hex, kind, given, about)
            self._jobs[job.id] = job
            self._queue.append(job)
            ended = [each.id for each in self._jobs.values() if each.ended]
            for each in ended[: max(len(ended) - KEPT, 0)]:
                del self._jobs[each]
            self._changed.notify_all()
            return job

    def job(self, number: str) -> Job:
        with self._changed:
            if number not in self._jobs:
                raise Absent("no such job; it ended long ago, or the server was started anew")
            return self._jobs[number]

    def all(self) -> list[Job]:
        with self._changed:
            return list(self._jobs.values())[::-1]

    def cancel(self, number: str) -> Job:
        """Cancel a job; a job that has ended is unchanged."""
        job = self.job(number)
        with self._changed:
            if not job.ended:
                job.state, job.text = CANCELLED, "cancelled"
                with suppress(ValueError):
                    self._queue.remove(job)
        return job

    def close(self) -> None:
        """Cancel all jobs and end all processes."""
        with self._changed:
            self._closed = True
            for job in self._jobs.values():
                if not job.ended:
                    job.state, job.text = CANCELLED, "the server was ended"
            self._queue.clear()
            self._changed.notify_all()
        for thread in self._threads:
            thread.join(timeout=5.0)
        for process, connection in self._spare:
            connection.close()
            process.terminate()
            process.join(timeout=5.0)

    def _work(self) -> None:
        """Loop of a thread: runs one job after another."""
        ready = self._process()
        while True:
            with self._changed:
                while not self._queue and not self._closed:
                    self._changed.wait()
                if self._closed:
                    self._spare.append(ready)
                    return
                job = self._queue.popleft()
                job.state, job.text = RUNNING, "starting"
            self._run(job, *ready)
            if self._closed:
                return
            ready = self._process()

    def _process(self) -> tuple[BaseProcess, Connection]:
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=serve, args=(theirs, self.limits.job_memory), daemon=True)
        with safe_path():
            process.start()
        theirs.close()
        return process, ours

    def _run(self, job: Job, process: BaseProcess, connection: Connection) -> None:
        until = time.monotonic() + self.limits.job_time
        # The waiting process may have died; its end is reported below.
        with suppress(BrokenPipeError):
            connection.send((job.kind, job.given))
        answer: object = None
        while job.state == RUNNING and answer is None:
            try:
                if connection.poll(LOOK):
                    answer = self._heard(job, connection.recv())
            except (EOFError, OSError):
                process.join(timeout=2.0)
                answer = Failure(self._how_it_ended(process.exitcode), lasting=False)
            if time.monotonic() > until and answer is None:
                answer = Failure(
                    f"it took longer than {self.limits.job_time:g} s; give a shorter recording", lasting=True
                )
        process.terminate()
        process.join(timeout=5.0)
        connection.close()
        self._end(job, answer)

    def _heard(self, job: Job, message: tuple[str, Any]) -> object:
        kind, content = message
        if kind != "progress":
            return content
        share, text, found = content
        job.share, job.text = max(job.share, min(float(share), 1.0)), text
        job.found = {**job.found, **found}
        return None

    def _end(self, job: Job, answer: object) -> None:
        if isinstance(answer, dict):
            job.found = answer
            # Before the state changes, so that a page that sees the job done finds its results.
            with suppress(OutputError):
                self._finished(job)
        with self._changed:
            if job.state == CANCELLED:
                return
            if isinstance(answer, dict):
                job.share, job.state, job.text = 1.0, DONE, ""
            else:
                reason = answer.reason if isinstance(answer, Failure) else " ".join(str(answer).split())
                job.state, job.text = FAILED, _named(reason, job.given)

    def _how_it_ended(self, code: int | None) -> str:
        memory = self.limits.job_memory >> 20
        return (
            f"its process was ended (code {code}); if memory was short, it reached its limit of {memory} MiB: give a "
            "shorter recording, or a larger --job-memory"
        )


def _named(reason: str, given: Mapping[str, Any]) -> str:
    """A reason with file names in place of paths: the page must not reveal where files lie on this machine."""
    for path in filter(None, (given.get("path"), *given.get("paths", ()))):
        reason = reason.replace(path, Path(path).name)
    return in_the_page(reason)


def workers_of(given: int | None) -> int:
    """Number of jobs at a time; half of the cores if not given."""
    from tierod.work.pool import cores

    if given is not None and given < 1:
        raise ParameterError(f"--workers needs at least one process, not {given}")
    return given or max(cores() // 2, 1)


OFTEN = 0.1  # Shortest time between two messages on progress [s]


def serve(connection: Connection, memory: int) -> None:
    """Run the process of a job.

    Args:
        connection: connection to the server, which sends (kind, arguments), and receives progress and the result
        memory: largest memory of the process [bytes]
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes; the server alone ends this one
    threading.Thread(target=_end_with_server, daemon=True).start()
    warnings.simplefilter("ignore", KernelWarning)
    from tierod.web.work import WORKS

    _limit(memory)
    with suppress(EOFError, OSError):
        kind, given = connection.recv()
        last = [0.0]

        def say(share: float, text: str, **found: Any) -> None:
            now = time.monotonic()
            if found or now - last[0] >= OFTEN:
                last[0] = now
                connection.send(("progress", (share, text, found)))

        connection.send(("end", done(lambda task: WORKS[kind](task, say), given)))


def _limit(memory: int) -> None:
    with suppress(ImportError, ValueError, OSError):
        import resource

        # RLIMIT_DATA does not count mapped files, which the store reads and writes.
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))


def _end_with_server() -> None:
    if (parent := parent_process()) is not None:
        import os

        parent.join()
        os._exit(1)
