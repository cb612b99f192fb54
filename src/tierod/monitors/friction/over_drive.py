"""What a report shows of friction over a drive, in memory that hardly grows with it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np

from tierod.errors import InputError
from tierod.identification.hysteresis_presence import HysteresisPresence, HysteresisPresenceTest

STRETCHES = 4
"""Parts of a drive without a change that get a histogram each."""

BINS = 60

VIEW_POINTS = 1200
"""Points of one hysteresis view: enough to see two bands and their width."""


class EstimateOverDrive:
    """Friction estimates, one a second, for histograms per stretch of the drive."""

    def __init__(self, rate: float):
        self._every = max(round(rate), 1)
        self._seen = 0
        self._time: list[np.ndarray] = []
        self._values: list[np.ndarray] = []

    def add(self, time: np.ndarray, estimate: np.ndarray, ready: np.ndarray) -> None:
        """Estimates that follow those already added; only those of the ready monitor count."""
        first = -self._seen % self._every
        self._seen += len(time)
        chosen = np.arange(first, len(time), self._every)
        chosen = chosen[ready[chosen] & np.isfinite(estimate[chosen])]
        self._time.append(time[chosen])
        self._values.append(estimate[chosen])

    def histograms(self, change: float | None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Name of a stretch -> (edges, counts).

        Args:
            change: time at which friction changed [s]; the stretches are then before and after it
        """
        time, values = np.concatenate(self._time or [np.empty(0)]), np.concatenate(self._values or [np.empty(0)])
        if not len(values):
            return {}
        high = float(np.quantile(values, 0.999)) * 1.1
        edges = np.linspace(min(0.0, float(values.min())), max(high, 1e-6), BINS + 1)
        found = {}
        for name, inside in _stretches(time, change).items():
            if inside.any():
                found[name] = (edges, np.histogram(np.clip(values[inside], edges[0], edges[-1]), edges)[0])
        return found


class HysteresisOverDrive:
    """Friction that acts over the angle of the wheel: points by the minute, thinned as the drive grows."""

    def __init__(self) -> None:
        self._parts: list[np.ndarray] = []
        self._random = np.random.default_rng(0)

    def add(self, time: np.ndarray, angle: np.ndarray, friction: np.ndarray, used: np.ndarray) -> None:
        """Points of a stretch: angle [rad], friction that acts there [N*m], whether the estimator used the sample."""
        rows = np.flatnonzero(used & np.isfinite(angle) & np.isfinite(friction))
        if len(rows) > VIEW_POINTS:
            rows = np.sort(self._random.choice(rows, VIEW_POINTS, replace=False))
        self._parts.append(np.column_stack([time[rows], angle[rows], friction[rows]]))

    def views(self, change: float | None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Name of a stretch -> (angle, friction that acts)."""
        points = np.vstack(self._parts or [np.empty((0, 3))])
        found = {}
        for name, inside in _stretches(points[:, 0], change, parts=2).items():
            rows = np.flatnonzero(inside)
            if len(rows) > VIEW_POINTS:
                rows = np.sort(self._random.choice(rows, VIEW_POINTS, replace=False))
            if len(rows):
                found[name] = (points[rows, 1], points[rows, 2])
        return found


class SignalsOverDrive:
    """Signals of the first minutes at half the rate, for tests that need a stretch as a whole."""

    SIGNALS = ("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque", "lateral_acceleration")
    LONGEST = 600.0

    def __init__(self) -> None:
        self._parts: list[np.ndarray] = []
        self._start: float | None = None

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """Signals that follow those already added."""
        self._start = float(time[0]) if self._start is None else self._start
        rows = np.flatnonzero(time < self._start + self.LONGEST)[::2]
        self._parts.append(np.column_stack([time[rows], *(signals[name][rows] for name in self.SIGNALS)]))

    def presence(self) -> HysteresisPresence | None:
        """Whether the driver's torque carries hysteresis; None where that cannot be tested."""
        time, *signals = np.vstack(self._parts).T
        try:
            return HysteresisPresenceTest().test(time, **dict(zip(self.SIGNALS, signals, strict=True)))
        except InputError:
            return None


def _stretches(time: np.ndarray, change: float | None, parts: int = STRETCHES) -> dict[str, np.ndarray]:
    if not len(time):
        return {}
    if change is not None and time[0] < change < time[-1]:
        return {"before the change": time < change, "after the change": time >= change}
    edges = np.linspace(time[0], time[-1], parts + 1)
    edges[-1] = np.inf
    names = [f"{low / 60.0:.0f} to {min(high, time[-1]) / 60.0:.0f} min" for low, high in itertools.pairwise(edges)]
    return {
        name: (time >= low) & (time < high) for name, (low, high) in zip(names, itertools.pairwise(edges), strict=True)
    }
