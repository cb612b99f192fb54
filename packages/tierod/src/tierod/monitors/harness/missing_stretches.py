"""Stretches of a recording in which an input signal of a monitor is missing while others continue."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Annotated

import numpy as np

from tierod.core.recording import Aligned
from tierod.core.series import last_true

LEAST: Annotated[float, "s"] = 1.0
"""Shortest missing stretch that is reported [s]."""

STEPS = 5.0
"""Shortest missing stretch of a slow signal, in its own sampling intervals [-]."""

NAMED = 3
"""Most stretches of one signal that a sentence lists; further ones are counted."""

MOST = 1000
"""Most stretches of one signal that are stored."""


class MissingStretches:
    """Records when each input signal of a monitor begins, pauses and ends.

    Args:
        names: input signals
        rate: rate of the monitor's grid [Hz]
    """

    def __init__(self, names: Collection[str], rate: float):
        self.names, self.rate = tuple(names), rate
        self._missing = dict.fromkeys(self.names, 0)
        self._open: dict[str, tuple[float, int]] = {}
        self._kept: dict[str, list[tuple[float, float, float]]] = {name: [] for name in self.names}
        self._seen: dict[str, float] = {}
        self._begin = self._end = math.nan

    def add(self, aligned: Aligned) -> None:
        """Add the next samples, as the monitor receives them."""
        if not len(aligned.time):
            return
        if not math.isfinite(self._begin):
            self._begin = float(aligned.time[0])
        self._end = float(aligned.time[-1])
        for name in self.names:
            if name in aligned.names:
                self._follow(name, aligned.time, aligned.there[name])

    def _follow(self, name: str, time: np.ndarray, there: np.ndarray) -> None:
        # The first edge compares with the end of the previous piece.
        edges = np.flatnonzero(np.concatenate([[(name not in self._open) != there[0]], there[1:] != there[:-1]]))
        before = 0
        for place in edges.tolist():
            if name in self._open:
                start, count = self._open.pop(name)
                self._keep(name, start, float(time[place]), count + place - before)
            else:
                self._open[name] = (float(time[place]), 0)
            before = place
        if name in self._open:
            start, count = self._open[name]
            self._open[name] = (start, count + len(time) - before)
        if (last := last_true(there)) is not None:
            self._seen[name] = float(time[last])

    def _keep(self, name: str, start: float, end: float, count: int) -> None:
        """Store a stretch; its length is counted in samples, since time without any recorded signal is skipped."""
        if count / self.rate > LEAST and len(self._kept[name]) < MOST:
            self._kept[name].append((start, end, count / self.rate))

    def warnings(self, rates: Mapping[str, float], others: Collection[str] = ()) -> tuple[str, ...]:
        """Warnings about missing signals: the stretches, and the consequence for the verdict.

        Args:
            rates: sampling rates of the signals [Hz]
            others: signals that another warning names
        """
        return tuple(
            self._sentence(name, found)
            for name in self.names
            if name in self._seen and name not in others and (found := self._found(name, rates.get(name, math.nan)))
        )

    def _found(self, name: str, rate: float) -> list[tuple[float, float, float]]:
        least = max(LEAST, STEPS / rate) if rate > 0.0 else LEAST
        open_ = [(start, math.inf, count / self.rate) for start, count in filter(None, [self._open.get(name)])]
        return [each for each in (*self._kept[name], *open_) if each[2] > least]

    def _sentence(self, name: str, found: list[tuple[float, float, float]]) -> str:
        listed = ", ".join(self._when(*each) for each in found[:NAMED])
        more = f" and {len(found) - NAMED} more times" if len(found) > NAMED else ""
        means = "estimates there rest on the other signals, or are held"
        return f"{name} is missing {listed}{more}: {means}; check the sensor and its messages"

    def _when(self, start: float, end: float, length: float) -> str:
        if math.isinf(end):
            return f"from {start:.1f} s on ({length:.3g} s to the end)"
        if start <= self._begin:
            return f"until {end:.1f} s"
        return f"from {start:.1f} s to {end:.1f} s"
