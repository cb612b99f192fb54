"""Compilers, checkers and emulators: availability, version and execution."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Annotated, NamedTuple, TypeVar

LONGEST: Annotated[float, "s"] = 600.0
"""Time limit for one run of a tool."""
AT_ONCE = 2
"""Number of tools that run concurrently."""


T = TypeVar("T")


class Outcome(NamedTuple):
    """Result of running a tool.

    Args:
        code: exit status; None where the tool could not be started or was stopped by the time limit
    """

    code: int | None
    text: str

    @property
    def first(self) -> str:
        """First line of the output, shortened."""
        return next(iter(self.text.strip().splitlines()), "nothing was written")[:160]


@cache
def there(name: str) -> bool:
    """Whether a tool is installed."""
    return shutil.which(name) is not None


@cache
def version(name: str) -> str:
    """Name and version of a tool, or a note that it is not installed."""
    if not there(name):
        return f"{name} is not installed"
    found = re.search(r"\d+\.\d+(\.\d+)?", ran([name, "--version"], Path(), 20.0).text)
    return f"{name} {found[0]}" if found else name


def ran(command: Sequence[str], folder: Path, limit: float = LONGEST) -> Outcome:
    """Run a tool to its end.

    Args:
        limit: time limit [s]
    """
    try:
        done = subprocess.run(
            list(command), cwd=folder, capture_output=True, text=True, errors="replace", check=False, timeout=limit
        )
    except subprocess.TimeoutExpired:
        return Outcome(None, f"did not end within {limit:g} s")
    except OSError as error:
        return Outcome(None, f"could not be run ({error.strerror})")
    return Outcome(done.returncode, done.stdout + done.stderr)


def at_once(calls: Sequence[Callable[[], T]]) -> list[T]:
    """Results of several calls, a few of which run concurrently, in the given order.

    Args:
        calls: independent of each other; they mostly wait for tools
    """
    with ThreadPoolExecutor(AT_ONCE) as pool:
        return [each.result() for each in [pool.submit(call) for call in calls]]
