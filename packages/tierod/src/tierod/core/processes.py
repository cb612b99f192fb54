"""Processes of this machine, child interpreters and their threads, locks between processes, and the end of this one."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from types import ModuleType
from typing import Annotated


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
    """Command line of a child interpreter."""
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


# Environment variables that limit the threads; a library reads them when it is loaded
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def one_thread_each() -> None:
    """Limit each library to one thread, unless the user chose another number.

    For a sum over a drive several waiting threads cost more than they save, and the last digit of the sum would depend
    on the number of cores.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")


# Longest wait for a lock [s]: work under a lock takes milliseconds, so that a queue of a hundred processes fits
PATIENCE: Annotated[float, "s"] = 30.0

# Polling interval for a lock [s]: short against the work that is done under it, long against the poll itself
LOOK_PERIOD: Annotated[float, "s"] = 0.01


@contextmanager
def alone(place: Path, patience: float = PATIENCE) -> Iterator[bool]:
    """Lock a file or folder against other processes and threads that lock it in the same way.

    Args:
        place: an existing file or folder; nothing is written to it
        patience: longest wait [s]; 0 tries once

    Yields:
        whether it is locked; False where the system cannot lock there
    """
    handle = _held(place, time.monotonic() + patience)
    try:
        yield handle is not None
    finally:
        if handle is not None:
            os.close(handle)


def _held(place: Path, end: float) -> int | None:
    """A file descriptor that holds the lock; None where the system cannot lock there."""
    try:
        import fcntl
    except ImportError:
        return None
    try:
        handle = os.open(place, os.O_RDONLY)
    except FileNotFoundError:
        raise
    except OSError:
        return None
    try:
        while not _taken(fcntl, handle):
            if time.monotonic() >= end:
                raise TimeoutError(f"another process holds {place}")
            time.sleep(LOOK_PERIOD)
        # The last holder may have replaced the file, and a third process may hold the new one.
        same = os.path.samestat(os.fstat(handle), os.stat(place))
    except _NoLocks:
        os.close(handle)
        return None
    except BaseException:
        os.close(handle)
        raise
    if same:
        return handle
    os.close(handle)
    return _held(place, end)


class _NoLocks(Exception):
    """The file system does not support locks."""


def _taken(fcntl: ModuleType, handle: int) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        raise _NoLocks from None
    return True
