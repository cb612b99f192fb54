"""The results of many drives for studies that do not hand over their effort yet."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from tierod.experiments.effort import Effort


def in_processes(work: Callable[[Any], Any], given: Sequence[Any], processes: int | None) -> list[Any]:
    """The results of everything given, in its order; errors as of `Effort.made`."""
    return Effort(processes=processes).made(work, given)
