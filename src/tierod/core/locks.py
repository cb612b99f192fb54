"""One process at a time at a file or folder: a lock ends with the process that holds it, and a wait ends too."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Annotated

PATIENCE: Annotated[float, "s"] = 30.0
"""Longest wait: what is done under a lock takes milliseconds, so that a queue of a hundred processes fits into it."""

LOOK_PERIOD: Annotated[float, "s"] = 0.01
"""Between two looks whether the lock is free: short against what is done under it, long against the look itself."""


@contextmanager
def alone(place: Path, patience: float = PATIENCE) -> Iterator[bool]:
    """Hold a file or folder against other processes and threads that hold it likewise.

    Args:
        place: exists; nothing is written to it
        patience: longest wait [s]; 0 looks once

    Yields:
        whether it is held; False where the system cannot lock there

    Raises:
        FileNotFoundError: it does not exist, or not any more once it is free
        TimeoutError: another process held it for all that time
    """
    handle = _held(place, time.monotonic() + patience)
    try:
        yield handle is not None
    finally:
        if handle is not None:
            os.close(handle)


def _held(place: Path, end: float) -> int | None:
    """A handle that holds the place; None where the system cannot lock there."""
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
    """The file system has no locks."""


def _taken(fcntl: ModuleType, handle: int) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        raise _NoLocks from None
    return True
