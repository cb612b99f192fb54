"""Result rows of a campaign, one per drive and monitor."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tierod_lab.campaign.definition import labels
from tierod_lab.campaign.judged import Judged

FAULT_FREE = "fault-free"
"""Level of the fault axis for drives without a fault."""

FAULT, SIZE, SEED = "fault", "size", "seed"
"""Axes of every campaign."""


@dataclass(frozen=True)
class Row:
    """Result of one monitor on one drive.

    Args:
        place: axis -> level
        drive: record of the drive: outcome "driven", "diverged" or "failed", reason, seconds, recording, provenance
        monitor: label of the monitor
        judged: its judgement; None if there is none
        reason: reason why there is none
    """

    place: Mapping[str, str]
    drive: Mapping[str, Any]
    monitor: str
    judged: Judged | None
    reason: str = ""

    @property
    def faulty(self) -> bool:
        """Whether the drive has a fault that actually started."""
        return self.place[FAULT] != FAULT_FREE and any(each["start"] is not None for each in self.drive["windows"])

    @property
    def given(self) -> str:
        """True state: the fault with its magnitude, or `FAULT_FREE`, also if the fault of the drive never started."""
        if self.drive["outcome"] == "driven" and not self.faulty:
            return FAULT_FREE
        return " ".join(part for part in (self.place[FAULT], self.place[SIZE]) if part)


def matching(rows: Iterable[Row], where: Mapping[str, object], monitor: str | None = None) -> list[Row]:
    """The rows at some levels."""
    return [row for row in rows if monitor in (None, row.monitor) and is_at(row.place, where)]


def is_at(place: Mapping[str, str], where: Mapping[str, object]) -> bool:
    return all(place.get(axis) in labels(levels) for axis, levels in where.items())
