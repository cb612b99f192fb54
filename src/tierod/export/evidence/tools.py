"""Compilers, checkers and emulators: whether they are there, which they are, and running them."""

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
"""Of one run of a tool."""
AT_ONCE = 2
"""Tools that run at a time."""


T = TypeVar("T")


class Outcome(NamedTuple):
    """Outcome of a tool's run.

    Args:
        code: with which it ended; None where it could not be run, or not to its end
        text: what it wrote, errors last
    """

    code: int | None
    text: str

    @property
    def first(self) -> str:
        """First line of the text, shortened."""
        return next(iter(self.text.strip().splitlines()), "nothing was written")[:160]


@cache
def there(name: str) -> bool:
    """Whether a tool is installed."""
    return shutil.which(name) is not None


@cache
def version(name: str) -> str:
    """Name and version of a tool; why there is none where it is absent."""
    if not there(name):
        return f"{name} is not installed"
    found = re.search(r"\d+\.\d+(\.\d+)?", ran([name, "--version"], Path(), 20.0).text)
    return f"{name} {found[0]}" if found else name


def ran(command: Sequence[str], folder: Path, limit: float = LONGEST) -> Outcome:
    """Run a tool to its end.

    Args:
        command: with its arguments
        folder: in which it runs
        limit: time after which it is ended [s]
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
    """What some calls give, which wait for tools most of the time; some at a time, the first ones first.

    Args:
        calls: of which none needs what another one writes
    """
    with ThreadPoolExecutor(AT_ONCE) as pool:
        return [each.result() for each in [pool.submit(call) for call in calls]]
