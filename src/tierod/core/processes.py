"""Processes of this machine, child interpreters, and the end of this one."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager


def runs(process: int) -> bool:
    """Whether a process is running.

    Args:
        process: its identifier; a process of another user counts as well
    """
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # no permission to signal it: it belongs to another user
        return True
    return True


def interpreter(*words: str) -> tuple[str, ...]:
    """Command line of a child interpreter.

    Args:
        words: what it runs, such as "-m", module and arguments
    """
    # Without -P it would import from the working folder, which may hold the files of others.
    return (sys.executable, "-P", *words)


_STARTING = threading.RLock()


@contextmanager
def safe_path() -> Iterator[None]:
    """Keep interpreters that `multiprocessing` starts meanwhile from importing from the working folder.

    The environment belongs to the whole process: threads that start interpreters do so one after the other.
    """
    name = "PYTHONSAFEPATH"
    with _STARTING:
        before = os.environ.get(name)
        os.environ[name] = "1"
        try:
            yield
        finally:
            if before is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = before


@contextmanager
def stopped_by_sigterm() -> Iterator[None]:
    """Handle SIGTERM like Ctrl-C, where this is the main thread: results are kept, and no process is left behind."""

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
