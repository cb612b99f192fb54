"""When the statistics of a monitor passed their thresholds, and how far they came: seen at every sample."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from tierod.monitors.harness.decision import Decision


class Passing:
    """Follows what every decision of a session compares, piece by piece.

    Args:
        decisions: those without a statistic are left out
        session: that takes them
    """

    def __init__(self, decisions: Iterable[Decision], session: Any):
        taken = [each for each in decisions if each.statistic and each.part_of(session) is not None]
        self._levels = {each.name: each.levels_in(session) for each in taken}
        self._decisions = {each.name: each for each in taken}
        self.reached: dict[str, float] = {}
        self.passed: dict[str, float] = {}

    def add(self, time: np.ndarray, shown: Mapping[str, np.ndarray]) -> None:
        """The next piece.

        Args:
            time: [s], (n,)
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
        if name in self.passed:
            return
        beyond = np.any([values <= level if low else values >= level for low, level in sides], axis=0)
        if beyond.any():
            self.passed[name] = float(time[np.argmax(beyond)])


def _sides(levels: tuple[float, ...], below: bool) -> list[tuple[bool, float]]:
    """(whether the rule acts below it, level) of every level; those of a rule without one are never passed."""
    return [(below or level < 0.0, level) for level in levels] or [(False, np.inf)]
