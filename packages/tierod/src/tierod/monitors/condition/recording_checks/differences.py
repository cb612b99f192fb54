"""Comparison of two estimates of one quantity, averaged over blocks of time, with their fault-free difference."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Annotated, NamedTuple

import numpy as np

BLOCK = 0.5
"""Length of a block, over which signals are averaged [s]; the noise of a wheel speed is .02 m/s**2 in its slope."""
LEAST_READ = 0.15
"""Least share of the samples of a block that a signal must have [-]; wheel speeds come at 20 Hz on slow buses."""

_TIME = "time"


class Blocks:
    """Cuts a drive into blocks, and stores the rest of each piece for the next one.

    Args:
        rate: sampling rate [Hz]
    """

    def __init__(self, rate: float):
        self.rate, self.width = rate, max(round(BLOCK * rate), 2)
        self._left: dict[str, np.ndarray] = {}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], list[float]]:
        """Blocks that the next piece completes, and the end of each.

        Args:
            time: time stamps [s], (n,); with a leap where a pause of the recording was skipped
            signals: signals by name, (n,) each; NaN if missing

        Returns:
            signals by name, (blocks, samples) each, and the ends of the blocks [s], (blocks,)
        """
        pieces = {**signals, _TIME: time}
        whole = {name: np.concatenate([self._left.get(name, values[:0]), values]) for name, values in pieces.items()}
        count = len(whole[_TIME]) // self.width
        used = count * self.width
        self._left = {name: values[used:].copy() for name, values in whole.items()}
        cut = {name: values[:used].reshape(count, self.width) for name, values in whole.items()}
        ends: list[float] = (cut.pop(_TIME)[:, -1] + 1.0 / self.rate).tolist()
        return cut, ends

    def line(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and slope per second of a regression line in every block, (blocks,) each; NaN with too few samples."""
        there = np.isfinite(values)
        weight = there.astype(float)
        count = weight.sum(axis=1)
        time = (np.arange(self.width) - 0.5 * (self.width - 1)) / self.rate
        known, safe = np.where(there, values, 0.0), np.maximum(count, 1.0)
        mean, middle = known.sum(axis=1) / safe, (weight * time).sum(axis=1) / safe
        apart = (time - middle[:, None]) * weight
        spread = (apart * time).sum(axis=1)
        slope = (apart * known).sum(axis=1) / np.where(spread > 0.0, spread, 1.0)
        enough = (count >= max(LEAST_READ * self.width, 3.0)) & (spread > 0.0)
        return np.where(enough, mean - slope * middle, np.nan), np.where(enough, slope, np.nan)


def roughness(values: np.ndarray) -> np.ndarray:
    """Standard deviation of white noise in every block, from the differences of consecutive samples; NaN with too few.

    Args:
        values: samples, (blocks, samples)
    """
    steps = np.diff(values, axis=1)
    there = np.isfinite(steps)
    count = there.sum(axis=1)
    squares = np.where(there, steps * steps, 0.0).sum(axis=1)
    return np.where(count >= 3, np.sqrt(0.5 * squares / np.maximum(count, 1)), np.nan)


LEVEL_TIME, SHAPE_TIME = 3.0, 10.0
"""Windows for the mean and for the standard deviation of a difference [s]."""
SWEEPS = 8
"""Iterations of the coordinate descent for gain and lag; the quadratic form in a box has a single minimum."""
HALF = 0.7
"""Least share of the blocks of a window in which both estimates must exist [-]."""


@dataclass(frozen=True)
class Bounds:
    """Bounds of the fault-free difference of two estimates of a quantity [unit of the quantity].

    Args:
        single: bound of the difference in one block
        level: bound of its mean over `LEVEL_TIME`, after subtraction of the fault-free gain
        shape: bound of its standard deviation over `SHAPE_TIME`, after subtraction of fault-free gain and lag
        share: alternative bound of that, as a share of the standard deviation of the quantity [-]; the larger applies
        noise: bound of the white noise of the reading, in the mean over `LEVEL_TIME`
        doubtful: share of these bounds from which a difference is doubtful [-]
        gain: largest fault-free part of the difference that is proportional to the quantity, as a share of it [-]
        lag: largest fault-free delay of the reading behind the quantity
    """

    single: float
    level: float
    shape: float
    share: Annotated[float, ""]
    noise: float
    doubtful: Annotated[float, ""] = 0.7
    gain: Annotated[float, ""] = 0.0
    lag: Annotated[float, "s"] = 0.0


def _deviation(values: Sequence[float]) -> float:
    """Standard deviation of few values, for which an array would be slower."""
    mean = sum(values) / len(values)
    return sqrt(sum((each - mean) ** 2 for each in values) / len(values))


def _unexplained(rows: Sequence[Row], gain: float, lag: float) -> float:
    """Standard deviation of the difference without the part that a fault-free gain and lag explain.

    Least squares of apart = a reference - b d(reference)/dt with 0 <= a <= gain and 0 <= b <= lag.
    """
    apart = np.array([each.apart for each in rows])
    motion = np.array([each.reference for each in rows])
    columns = np.array([motion, -np.gradient(motion, [each.end for each in rows])])
    columns -= columns.mean(axis=1, keepdims=True)
    squares, products = columns @ columns.T, columns @ apart
    most, share = np.array([gain, lag]), np.zeros(2)
    for _ in range(SWEEPS):
        for place in (0, 1):
            left = products[place] - squares[place] @ share + squares[place, place] * share[place]
            if squares[place, place] > 0.0:
                share[place] = min(max(left / squares[place, place], 0.0), most[place])
    return float(np.std(apart - share @ columns))


class Row(NamedTuple):
    """One block: its end [s], difference of the estimates, reference quantity, and noise of the reading."""

    end: float
    apart: float
    reference: float
    noise: float


class Difference(NamedTuple):
    """Difference beyond its bounds.

    Args:
        sure: whether it exceeds a bound; otherwise only the doubtful share of one
        window: start of the window in which it was detected [s]
        start: time at which the difference reached that magnitude, to half a second [s]
        found: time of the detection [s]
        magnitude: single difference, mean, standard deviation or noise
    """

    sure: bool
    window: Annotated[float, "s"]
    start: Annotated[float, "s"]
    found: Annotated[float, "s"]
    magnitude: float


class _Measure(NamedTuple):
    """Start of a window [s], magnitude of the difference over the window, and its bound."""

    begin: float
    magnitude: float
    bound: float


class DifferenceCheck:
    """Compare a difference with its bounds; keep the first one that is sure, or else the first doubtful one.

    Args:
        bounds: bounds of fault-free differences
    """

    def __init__(self, bounds: Bounds):
        self._bounds = bounds
        self._rows: deque[Row] = deque(maxlen=round(SHAPE_TIME / BLOCK))
        self.found: Difference | None = None

    @property
    def sure(self) -> bool:
        """Whether a difference beyond a bound was found."""
        return self.found is not None and self.found.sure

    def add(self, row: Row) -> bool:
        """Add the next block; returns whether the difference exceeds a bound now for the first time."""
        if self.sure:
            return False
        self._rows.append(row)
        if not isfinite(row.apart):
            return False
        measures = self._measures()
        sure = next((each for each in measures if each.magnitude > each.bound), None)
        doubtful = self._bounds.doubtful
        hit = sure or next((each for each in measures[1:] if each.magnitude > doubtful * each.bound), None)
        if hit is not None and (sure or self.found is None):
            begin, magnitude = hit.begin, hit.magnitude
            much = [
                each.end for each in self._rows if each.end > begin and max(abs(each.apart), each.noise) >= magnitude
            ]
            start = much[0] - BLOCK if much else begin
            self.found = Difference(sure is not None, begin, start, row.end, magnitude)
        return sure is not None

    def _measures(self) -> list[_Measure]:
        """Measures of the last block, mean, noise and standard deviation; the first of these cannot be doubtful."""
        bounds, last = self._bounds, self._rows[-1]
        found = [_Measure(last.end - BLOCK, abs(last.apart), bounds.single)]
        short = round(LEVEL_TIME / BLOCK)
        known = [each for each in self._rows if isfinite(each.apart)]
        recent = [each for each in known if each.end > last.end - LEVEL_TIME - 0.5 * BLOCK][-short:]
        if len(recent) >= HALF * short:
            begin, count = recent[0].end - BLOCK, len(recent)
            apart, most = sum(each.apart for each in recent), bounds.gain * sum(each.reference for each in recent)
            # Subtract what a gain between 0 and its bound explains; `most` has the sign of the reference.
            beyond = apart - min(max(apart, min(most, 0.0)), max(most, 0.0))
            found.append(_Measure(begin, abs(beyond) / count, bounds.level))
            found.append(_Measure(begin, sum(each.noise for each in recent) / count, bounds.noise))
        if len(known) >= HALF * SHAPE_TIME / BLOCK:
            bound = max(bounds.shape, bounds.share * _deviation([each.reference for each in known]))
            apart = _unexplained(known, bounds.gain, bounds.lag)
            found.append(_Measure(known[0].end - BLOCK, apart, bound))
        return found
