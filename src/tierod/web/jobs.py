"""Work in processes: a queue, progress, cancelling, and limits of time and memory.

`experiments.executor` runs lots of tasks to their end; here each job has a process of its own, so that one can be
cancelled, and outgrow its limits, without the others. A process waits ready, with everything imported.
"""

from __future__ import annotations

import threading
import time
import uuid
from collections import OrderedDict, deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from tierod.core.errors import OutputError, ParameterError
from tierod.experiments.executor import Failure
from tierod.web.errors import Absent, Busy
from tierod.web.site import Limits
from tierod.web.wording import in_the_page
from tierod.web.worker import serve

KEPT = 500
"""Finished jobs that are remembered."""

LOOK = 0.2
"""Between two looks whether a job shall end [s]."""

WAITING, RUNNING, DONE, FAILED, CANCELLED = "waiting", "running", "done", "failed", "cancelled"


@dataclass
class Job:
    """One piece of work.

    Args:
        id: in addresses
        kind: of the work
        given: what it takes
        about: in words
        state: waiting, running, done, failed or cancelled
        share: done, 0 to 1
        text: what is done now, or why it failed
        found: what is there already; the result once it is done
    """

    id: str
    kind: str
    given: dict[str, Any]
    about: str
    state: str = WAITING
    share: float = 0.0
    text: str = ""
    found: dict[str, Any] = field(default_factory=dict)
    created: float = field(default_factory=time.time)

    @property
    def ended(self) -> bool:
        """Whether nothing more happens to it."""
        return self.state in (DONE, FAILED, CANCELLED)


class Jobs:
    """The queue; `close` ends all.

    Args:
        workers: how many work at a time
        limits: of every job
        finished: called with a job that has ended well
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
        """Put work into the queue; the same work that waits or runs already is given back.

        Args:
            kind: of the work, see `tierod.web.work`
            given: what it takes, as JSON holds it
            about: in words

        Raises:
            Busy: too much waits
        """
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
        """A job by its id.

        Raises:
            Absent: there is none, or it ended long ago
        """
        with self._changed:
            if number not in self._jobs:
                raise Absent("no such job; it ended long ago, or the server was started anew")
            return self._jobs[number]

    def all(self) -> list[Job]:
        """Every job that is remembered, the newest first."""
        with self._changed:
            return list(self._jobs.values())[::-1]

    def cancel(self, number: str) -> Job:
        """End a job; one that has ended stays as it is.

        Raises:
            Absent: there is none
        """
        job = self.job(number)
        with self._changed:
            if not job.ended:
                job.state, job.text = CANCELLED, "cancelled"
                with suppress(ValueError):
                    self._queue.remove(job)
        return job

    def close(self) -> None:
        """End all jobs and processes."""
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
        """Work of a thread: one job after the other."""
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
        process.start()
        theirs.close()
        return process, ours

    def _run(self, job: Job, process: BaseProcess, connection: Connection) -> None:
        until = time.monotonic() + self.limits.job_time
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
            f"its process was ended (code {code}); where memory was short, its limit of {memory} MiB was met: give a "
            "shorter recording, or a larger --job-memory"
        )


def _named(reason: str, given: Mapping[str, Any]) -> str:
    """A reason in which files go by their names: where they lie on this machine is nothing for the page."""
    for path in filter(None, (given.get("path"), *given.get("paths", ()))):
        reason = reason.replace(path, Path(path).name)
    return in_the_page(reason)


def workers_of(given: int | None) -> int:
    """Number of jobs that work at a time; half of the cores where not given.

    Raises:
        ParameterError: fewer than one
    """
    from tierod.experiments.doors import cores

    if given is not None and given < 1:
        raise ParameterError(f"--workers needs at least one process, not {given}")
    return given or max(cores() // 2, 1)
