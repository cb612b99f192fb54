"""How much work a study may take, and how it reports its progress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Progress = Callable[[float, str], None]
"""Called with the share done (0 to 1) and what comes next."""


@dataclass(frozen=True)
class Effort:
    """How much is put into a study.

    Args:
        quick: a few minutes of driving only: shows that everything works, its figures say little
        processes: worker processes; one per core if None
        thorough: hours of driving more, where a study counts what is rare
    """

    quick: bool = False
    processes: int | None = None
    thorough: bool = False
