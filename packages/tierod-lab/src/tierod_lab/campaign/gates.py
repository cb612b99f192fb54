"""Gates: limits on figures of a campaign, which are met, missed, or cannot be judged."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tierod.core.claims import Goal
from tierod_lab.campaign.definition import labels
from tierod_lab.campaign.pools import Pool, pool
from tierod_lab.campaign.rows import FAULT, FAULT_FREE, SIZE, Row, matching


@dataclass(frozen=True)
class Gate:
    """A limit on a figure.

    Args:
        figure: field of `Pool`
        goal: permitted values
        where: axis -> level or levels
        monitor: label
    """

    figure: str
    goal: Goal
    where: Mapping[str, object]
    monitor: str

    @property
    def name(self) -> str:
        """Figure and place in words."""
        place = ", ".join(f"{axis} {' or '.join(labels(levels))}" for axis, levels in self.where.items())
        return f"{self.figure}{f' ({place})' if place else ''}"


@dataclass(frozen=True)
class Passed:
    """Result of a gate.

    Args:
        gate: the gate
        measured: value of the figure; NaN if there is none
        met: whether the goal is met; None if that cannot be judged
        note: reason why not, or number of drives
    """

    gate: Gate
    measured: float
    met: bool | None
    note: str


def pass_through(gate: Gate, rows: Sequence[Row]) -> Passed:
    """Compare the figure of a gate with its goal; with failed drives a gate can be missed, but not met."""
    figures = pool_at(rows, gate.where, gate.monitor)
    measured = float(getattr(figures, gate.figure))
    lost = figures.failed + figures.diverged
    if math.isnan(measured):
        return Passed(gate, measured, None, "there are no data for this figure")
    if not gate.goal.holds(measured):
        return Passed(gate, measured, False, f"{figures.drives} drives")
    if lost:
        return Passed(gate, measured, None, f"{lost} of {figures.drives} drives failed, so it cannot be judged as met")
    return Passed(gate, measured, True, f"{figures.drives} drives")


def pool_at(rows: Sequence[Row], where: Mapping[str, object], monitor: str) -> Pool:
    """Figures of the rows at some levels; faulty drives are compared with the fault-free ones of the other levels."""
    others = {axis: level for axis, level in where.items() if axis not in (FAULT, SIZE)}
    fault_free = matching(rows, {**others, FAULT: FAULT_FREE}, monitor)
    return pool(matching(rows, where, monitor), fault_free)
