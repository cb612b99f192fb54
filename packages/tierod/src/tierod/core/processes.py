"""Processes of this machine, child interpreters, and the end of this one."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager


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
def environment(values: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables for the processes that are started meanwhile.

    The environment belongs to the whole process: threads that start others do so one after the other.
    """
    with _STARTING:
        before = {name: os.environ.get(name) for name in values}
        os.environ.update(values)
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value


def safe_path() -> AbstractContextManager[None]:
    """Keep interpreters that `multiprocessing` starts meanwhile from importing from the working folder."""
    return environment({"PYTHONSAFEPATH": "1"})


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
