"""Process of one job: waits for the job, works on it within its limits, and reports its progress."""

from __future__ import annotations

import signal
import threading
import time
import warnings
from contextlib import suppress
from multiprocessing import parent_process
from multiprocessing.connection import Connection
from typing import Any

from tierod.core.errors import KernelWarning
from tierod.work.executor import done

OFTEN = 0.1
"""Shortest time between two messages on progress [s]."""


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
