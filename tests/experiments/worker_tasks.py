"""Tasks for worker processes, which import them by name."""

import errno
import os
import signal
import time
from pathlib import Path

from tierod.core.errors import InputError, OutputError


def environment():
    """In which a process of its own finds these tasks."""
    paths = [str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    return os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}


def do(task):
    kind, value = task
    if kind == "square":
        return value * value
    if kind == "late":
        time.sleep(value)
        return value
    if kind == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    if kind == "refused":
        raise InputError(f"{value} is no square")
    if kind == "defect":
        raise ZeroDivisionError("division by zero")
    if kind == "hungry":
        raise MemoryError
    if kind == "full":
        raise OutputError("the disk is full") if value else OSError(errno.ENOSPC, "No space left on device", "a.json")
    raise AssertionError(kind)


def noted(log, number, pause=0.0):
    """The square of a number, which is noted in a file."""
    with open(log, "a") as file:
        file.write(f"{number}\n")
    time.sleep(pause)
    return number * number
