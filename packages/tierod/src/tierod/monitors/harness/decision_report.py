"""Decisions of a session for a report: statistics, times of passing the threshold, and trade-off curves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.findings import Curve, Decided
from tierod.monitors.harness.decision import Decision


class Passing:
    """Follows the statistic of every decision of a session: its extreme value, and when it passes its threshold.

    Args:
        decisions: decisions of the variant; those without a statistic are ignored
        session: session that makes the decisions

    `reached` holds the extreme values, `passed` the times of the first passage [s], both by name of the decision.
    """

    def __init__(self, decisions: Iterable[Decision], session: Any):
        taken = [each for each in decisions if each.statistic and each.part_of(session) is not None]
        self._levels = {each.name: each.levels_in(session) for each in taken}
        self._decisions = {each.name: each for each in taken}
        self.reached: dict[str, float] = {}
        self.passed: dict[str, float] = {}

    def add(self, time: np.ndarray, shown: Mapping[str, np.ndarray]) -> None:
        """Add the next piece.

        Args:
            time: time stamps [s], (n,)
            shown: traces by name, (n,) each
        """
        for name, decision in self._decisions.items():
            values = shown.get(decision.statistic)
            if values is not None and np.isfinite(values).any():
                self._follow(name, decision.below, time, values)

    def _follow(self, name: str, below: bool, time: np.ndarray, values: np.ndarray) -> None:
        sides = _sides(self._levels[name], below)
        extremes = [float(np.nanmin(values)) if low else float(np.nanmax(values)) for low, _ in sides]
        known = [*extremes, *([self.reached[name]] if name in self.reached else [])]
        self.reached[name] = min(known) if below else max(known, key=abs)
        reaches = [each <= level if low else each >= level for each, (low, level) in zip(extremes, sides, strict=True)]
        if name in self.passed or not any(reaches):
            return
        beyond = np.any([values <= level if low else values >= level for low, level in sides], axis=0)
        self.passed[name] = float(time[np.argmax(beyond)])


def _sides(levels: tuple[float, ...], below: bool) -> list[tuple[bool, float]]:
    """(whether the rule acts below the level, level) of every level; a rule without a level is never passed."""
    return [(below or level < 0.0, level) for level in levels] or [(False, np.inf)]


SHARES = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)
"""Thresholds of a trade-off curve, as shares of the designed threshold [-]."""

SIZES = 25
"""Intervals of a curve of detection probability over the size of the change."""


def decided(
    decisions: Iterable[Decision],
    session: Any,
    reached: Mapping[str, float] = MappingProxyType({}),
    passed: Mapping[str, float] = MappingProxyType({}),
) -> tuple[Decided, ...]:
    """Decisions of a session for its report, without those of parts that the vehicle lacks.

    Args:
        decisions: decisions of the variant
        session: session that makes the decisions
        reached: extreme value of each statistic, by name of the decision
        passed: time at which each statistic first passed its threshold [s], by name of the decision
    """
    return tuple(
        Decided(
            each.name,
            each.distance,
            each.rule_in_words,
            each.false_alarms_in_words,
            each.source,
            each.statistic,
            each.levels_in(session),
            curve_of(each),
            each.below,
            reached.get(each.name),
            passed.get(each.name),
        )
        for each in decisions
        if each.part_of(session) is not None
    )


def curve_of(decision: Decision) -> Curve | None:
    """Trade-off curve of a rule: detection delay over mean time between false alarms.

    For a single test per recording it is the probability of detection over the size of the change instead.
    """
    design = decision.design
    if design is None:
        return None
    if math.isinf(design.spacing):
        sizes = [2.0 * design.threshold * number / SIZES for number in range(SIZES + 1)]
        chances = [1.0 / design.rule.run_length(design.threshold, size) for size in sizes]
        title = "size of the change [standard deviations]"
        return Curve(tuple(sizes), tuple(chances), title, "chance to find it", (design.threshold, 0.5), chance=True)
    points = []
    for share in SHARES:
        threshold = share * design.threshold
        try:
            hours = design.run_length(threshold) * design.spacing / 3600.0
            points.append((hours, design.delay(threshold) * design.spacing))
        except ParameterError:
            continue
    points = [point for point in points if all(map(math.isfinite, point))]
    chosen = (
        design.values * design.spacing / 3600.0,
        design.delay(design.threshold) * design.spacing,
    )
    along, up = zip(*points, strict=True) if points else ((), ())
    return Curve(along, up, "between false alarms [h]", "delay at the shift [s]", chosen)
