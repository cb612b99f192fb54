"""Exclusive locks on files and folders: a lock ends with the process that holds it, and waiting for it is bounded."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Annotated

PATIENCE: Annotated[float, "s"] = 30.0
"""Longest wait for a lock [s]: work under a lock takes milliseconds, so that a queue of a hundred processes fits."""

LOOK_PERIOD: Annotated[float, "s"] = 0.01
"""Polling interval for a lock [s]: short against the work that is done under it, long against the poll itself."""


@contextmanager
def alone(place: Path, patience: float = PATIENCE) -> Iterator[bool]:
    """Lock a file or folder against other processes and threads that lock it in the same way.

    Args:
        place: an existing file or folder; nothing is written to it
        patience: longest wait [s]; 0 tries once

    Yields:
        whether it is locked; False where the system cannot lock there

    Raises:
        FileNotFoundError: it does not exist, or was removed during the wait
        TimeoutError: another process held the lock for all that time
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
