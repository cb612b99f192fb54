"""Friction over a drive for a report, in memory that hardly grows with it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.series import Rows, Stride
from tierod.methods.identification.hysteresis_presence import HysteresisPresence, HysteresisPresenceTest

STRETCHES = 4
"""Number of parts into which a drive without a change is divided, each with a histogram."""

BINS = 60

STROKES, STROKE_SECONDS, STROKE_RATE = 12, 8.0, 25.0
"""Number of strokes in a hysteresis view, their length [s] and points per second: enough to show the loop width."""

STROKES_OF = 600.0
"""Length of the stretches whose busiest strokes are kept [s]."""


class EstimateOverDrive:
    """Friction estimates, one per second, for histograms per stretch of the drive."""

    def __init__(self, rate: float):
        self._stride = Stride(max(round(rate), 1))
        self._rows = Rows(2)

    def add(self, time: np.ndarray, estimate: np.ndarray, ready: np.ndarray) -> None:
        """Add estimates that follow those already added; only those of the ready monitor count."""
        chosen = self._stride.indices(len(time))
        chosen = chosen[ready[chosen] & np.isfinite(estimate[chosen])]
        self._rows.add(np.column_stack([time[chosen], estimate[chosen]]))

    def histograms(self, change: float | None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Name of a stretch -> (edges, counts).

        Args:
            change: time at which friction changed [s]; the stretches are then before and after it
        """
        time, values = self._rows.values.T
        if not len(values):
            return {}
        # A quantile, so that a few outliers do not stretch the bins; they are clipped into the last one.
        high = float(np.quantile(values, 0.999)) * 1.1
        edges = np.linspace(min(0.0, float(values.min())), max(high, 1e-6), BINS + 1)
        found = {}
        for name, inside in _stretches(time, change).items():
            if inside.any():
                found[name] = (edges, np.histogram(np.clip(values[inside], edges[0], edges[-1]), edges)[0])
        return found


class HysteresisOverDrive:
    """Strokes of the steering wheel with the friction that acted in them: the busiest few seconds of every ten minutes.

    Strokes follow one another from the first sample on, however the drive is cut into pieces.

    Args:
        rate: sampling rate [Hz]
    """

    def __init__(self, rate: float):
        step = max(round(rate / STROKE_RATE), 1)
        self._stride, self._length = Stride(step), max(round(STROKE_SECONDS * rate / step), 2)
        self._open = np.empty((0, 3))
        self._strokes: list[Stroke] = []
        self._closed: list[Stroke] = []

    def add(self, time: np.ndarray, angle: np.ndarray, friction: np.ndarray, used: np.ndarray) -> None:
        """Add a piece: angle [rad], acting friction [N*m], and whether the estimator used the sample."""
        acting = np.where(used & np.isfinite(angle), friction, np.nan)
        rows = np.column_stack([time, angle, acting])[self._stride.over(len(time))]
        rows = np.vstack([self._open, rows])
        whole = len(rows) // self._length * self._length
        for stroke in rows[:whole].reshape(-1, self._length, 3):
            busy = float(np.mean(np.isfinite(stroke[:, 2])))
            if busy > 0.0:
                self._keep(Stroke(busy, float(stroke[0, 0]), stroke[:, 1:].copy()))
        self._open = rows[whole:].copy()

    def _keep(self, stroke: Stroke) -> None:
        """Keep the busiest strokes of every ten minutes."""
        if self._strokes and stroke.start - self._strokes[0].start > STROKES_OF:
            self._closed += _busiest(self._strokes)
            self._strokes = []
        self._strokes.append(stroke)

    def views(self, change: float | None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Name of a stretch -> (angle, acting friction), with a NaN row after every stroke."""
        strokes = [*self._closed, *_busiest(self._strokes)]
        times = np.array([stroke.start for stroke in strokes])
        gap = np.full((1, 2), np.nan)
        found = {}
        for name, inside in _stretches(times, change, parts=2).items():
            chosen = [strokes[at] for at in np.flatnonzero(inside)[-STROKES:]]
            if chosen:
                points = np.vstack([part for stroke in chosen for part in (stroke.points, gap)])
                found[name] = (points[:, 0], points[:, 1])
        return found


class Stroke(NamedTuple):
    """A few seconds of steering.

    Args:
        busy: share of the samples that the estimator used [-]
        start: time of the first sample
        points: angle [rad] and acting friction [N*m], (n, 2)
    """

    busy: float
    start: Annotated[float, "s"]
    points: np.ndarray


def _busiest(strokes: list[Stroke]) -> list[Stroke]:
    """The busiest strokes in order of time; of equally busy ones the latest."""
    chosen = sorted(strokes, key=lambda stroke: (stroke.busy, stroke.start))[-STROKES:]
    return sorted(chosen, key=lambda stroke: stroke.start)


class SignalsOverDrive:
    """Signals of the first ten minutes at half the rate, for tests that need a stretch as a whole."""

    SIGNALS = ("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque", "lateral_acceleration")
    LONGEST = 600.0

    def __init__(self) -> None:
        self._rows = Rows(1 + len(self.SIGNALS))
        self._start: float | None = None
        self._stride = Stride(2)

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """Add signals that follow those already added."""
        self._start = float(time[0]) if self._start is None else self._start
        rows = self._stride.indices(len(time))
        rows = rows[time[rows] < self._start + self.LONGEST]
        self._rows.add(np.column_stack([time[rows], *(signals[name][rows] for name in self.SIGNALS)]))

    def presence(self) -> HysteresisPresence | None:
        """Result of the test for hysteresis in the driver's torque; None where it cannot be tested."""
        time, *signals = self._rows.values.T
        try:
            return HysteresisPresenceTest().test(time, **dict(zip(self.SIGNALS, signals, strict=True)))
        except InputError:
            return None


def _stretches(time: np.ndarray, change: float | None, parts: int = STRETCHES) -> dict[str, np.ndarray]:
    if not len(time):
        return {}
    if change is not None and time[0] < change < time[-1]:
        return {"before the change": time < change, "after the change": time >= change}
    if time[-1] - time[0] < parts:
        return {"the whole drive": np.ones(len(time), bool)}
    edges = np.linspace(time[0], time[-1], parts + 1)
    inner = np.concatenate([edges[:-1], [np.inf]])
    return {
        _stretch(*ends): (time >= low) & (time < high)
        for ends, (low, high) in zip(itertools.pairwise(edges), itertools.pairwise(inner), strict=True)
    }


def _stretch(low: float, high: float) -> str:
    """The name of a stretch from `low` to `high` [s], fine enough that no two neighbours share one."""
    if high - low < 60.0:
        return f"{low:.0f} to {high:.0f} s"
    decimals = 1 if high - low < 600.0 else 0
    first, last = (f"{each / 60.0:.{decimals}f}".removesuffix(".0") for each in (low, high))
    return f"{first} to {last} min"
