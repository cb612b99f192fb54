"""The bank of a vehicle that nobody has calibrated: it tells sizes as widely as its predictions err."""

from __future__ import annotations

from dataclasses import replace

from tierod.core.graph import Bank
from tierod.monitors.condition.signals import SENSORS
from tierod.monitors.condition.substitutes import FILTER, substitution_graph


def unsure(bank: Bank) -> Bank:
    """A bank whose kinds and sizes of faults reckon with what predictions of uncalibrated vehicles are off by.

    Args:
        bank: of the condition monitor, with a `ConditionJudge`
    """
    ways = substitution_graph(calibrated=False).substitutes
    errors = [next(way.deviation for way in ways[name] if way.name == FILTER) for name in SENSORS]
    kinds = tuple(replace(kind, unknown=error) for kind, error in zip(bank.judge.kinds, errors, strict=True))
    return replace(bank, judge=replace(bank.judge, kinds=kinds))
