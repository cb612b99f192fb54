"""The bank of a vehicle that nobody has calibrated: it says less of kinds and sizes, and says them less surely."""

from __future__ import annotations

from dataclasses import replace

from tierod.graph import Bank
from tierod.monitors.condition.signals import SENSORS
from tierod.monitors.condition.substitutes import FILTER, substitution_graph

ALIKE = 2.0
"""Parameters that are wrong make predictions err alike through a bend [s]: a third of what a turn of a round takes."""
LASTING = 20.0
"""Errors of a size do not average out over a fault, since offsets and radii stay as wrong as they are [s]."""


def unsure(bank: Bank) -> Bank:
    """A bank whose kinds of faults reckon with what predictions are off by on vehicles that nobody has calibrated.

    Args:
        bank: of the condition monitor, with a `ConditionJudge`
    """
    ways = substitution_graph(calibrated=False).substitutes
    errors = [next(way.deviation for way in ways[name] if way.name == FILTER) for name in SENSORS]
    kinds = tuple(
        replace(kind, unknown=error, alike=ALIKE, lasting=LASTING)
        for kind, error in zip(bank.judge.kinds, errors, strict=True)
    )
    return replace(bank, judge=replace(bank.judge, kinds=kinds))
