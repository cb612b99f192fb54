"""One row per drive and monitor: what was asked, what became of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tierod.experiments.definition import label
from tierod.experiments.judged import Judged

FAULT_FREE = "fault-free"
"""What a drive without a fault is called where faults have names."""

FAULT, SIZE, SEED = "fault", "size", "seed"
"""Axes that every campaign has."""


@dataclass(frozen=True)
class Row:
    """Result of one monitor on one drive.

    Args:
        place: axis -> level
        drive: record of the drive: outcome "driven", "diverged" or "failed", reason, seconds, recording, provenance
        monitor: label of the monitor
        judged: what it made of it; None where it did not come to that
        reason: why it did not
    """

    place: Mapping[str, str]
    drive: Mapping[str, Any]
    monitor: str
    judged: Judged | None
    reason: str = ""

    @property
    def faulty(self) -> bool:
        """Whether a fault was given, and came."""
        return self.place[FAULT] != FAULT_FREE and any(each["start"] is not None for each in self.drive["windows"])

    @property
    def given(self) -> str:
        """True state: `FAULT_FREE`, or the fault with its magnitude; `FAULT_FREE` too where the fault never came."""
        if self.drive["outcome"] == "driven" and not self.faulty:
            return FAULT_FREE
        return " ".join(part for part in (self.place[FAULT], self.place[SIZE]) if part)


def matching(rows: Iterable[Row], where: Mapping[str, object], monitor: str | None = None) -> list[Row]:
    """The rows at some levels.

    Args:
        rows: to choose from
        where: axis -> level, or a list of levels; axes that are not named may have any
        monitor: label; any where None
    """
    return [row for row in rows if monitor in (None, row.monitor) and is_at(row.place, where)]


def is_at(place: Mapping[str, str], where: Mapping[str, object]) -> bool:
    """Whether a place has the levels asked for."""
    return all(
        place.get(axis) in [label(level) for level in (levels if isinstance(levels, list | tuple) else [levels])]
        for axis, levels in where.items()
    )
