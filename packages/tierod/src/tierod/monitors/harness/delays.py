"""Delay and gain between two signals that follow each other, by cross-correlation block by block over a drive."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

RATE = 50.0
"""Sampling rate of the comparison [Hz]: steering moves below 5 Hz, and the peak of the correlation is interpolated."""

BLOCK = 1024
"""Samples of one block, 20 s: many turns of the wheel, while a missing sample discards no more than one block."""

LONGEST = 50
"""Largest delay that is searched, in samples: one second."""


SPAN = 20
"""Span of the differences that are compared, in samples (0.4 s): emphasises 0.4 to 2 Hz, where drivers steer."""


@dataclass(frozen=True)
class Lag:
    """Lag of one signal behind another.

    Args:
        delay: delay of the second signal against the first; negative if the first is late [s]
        deviation: standard deviation of the delay, from its scatter between blocks [s]
        correlation: correlation coefficient of the differences at that delay [-]
        gain: regression of the second signal on the first, slow turns included
        gain_correlation: correlation coefficient of the signals themselves, at zero delay [-]
        seconds: duration of the compared blocks [s]
    """

    delay: Annotated[float, "s"]
    deviation: Annotated[float, "s"]
    correlation: float
    gain: float
    gain_correlation: float
    seconds: Annotated[float, "s"]


@dataclass
class LagOverDrive:
    """Accumulates the correlations of all blocks of a drive.

    Args:
        smallest: least root mean square of the first signal's differences in a block [unit of the signal]; below it
            the block would compare noise
    """

    smallest: float
    _cross: np.ndarray = field(default_factory=lambda: np.zeros(2 * LONGEST + 1))
    _powers: np.ndarray = field(default_factory=lambda: np.zeros(2))
    _slow: np.ndarray = field(default_factory=lambda: np.zeros((2, 2)))
    _delays: list[tuple[float, float]] = field(default_factory=list)

    def add(self, first: np.ndarray, second: np.ndarray, usable: np.ndarray | None = None) -> None:
        """Add one block of both signals; a block with missing samples is discarded.

        Args:
            first, second: signals, (BLOCK,) each
            usable: samples that are compared, (BLOCK,); all if None
        """
        both = np.array([first, second])
        if not np.isfinite(both).all():
            return
        first, second = _change(both)
        if usable is not None:
            # The other samples of the second signal are kept beside those of the first, or the peak moves to zero.
            inside = usable[SPAN:] & usable[:-SPAN]
            first, near = np.where(inside, first, 0.0), np.convolve(inside, np.ones(2 * LONGEST + 1), "same") > 0.5
            second = np.where(near, second, 0.0)
        power = float(first @ first)
        if power < len(first) * self.smallest**2:
            return
        cross = _cross_correlation(first, second)
        both -= both.mean(axis=1, keepdims=True)
        self._cross += cross
        self._powers += (power, float(second @ second))
        self._slow += both @ both.T
        self._delays.append((_peak(cross)[0], power))

    def found(self) -> Lag | None:
        """Lag over the drive; None with fewer than two blocks, or if the second signal did not change."""
        norm, slow = math.sqrt(self._powers.prod()), self._slow
        if len(self._delays) < 2 or not norm > 0.0:
            return None
        lag, height = _peak(self._cross)
        delays, weights = np.array(self._delays).T
        # Scatter between blocks with the weights of the sums; the interpolation is no better than a tenth of a sample.
        share = weights / weights.sum()
        spread = math.sqrt(float(share @ (delays - lag) ** 2) * float(share @ share))
        return Lag(
            lag / RATE,
            max(spread, 0.1) / RATE,
            height / norm,
            float(slow[0, 1] / slow[0, 0]),
            float(slow[0, 1] / math.sqrt(slow[0, 0] * slow[1, 1])),
            len(delays) * BLOCK / RATE,
        )


def _change(values: np.ndarray) -> np.ndarray:
    """Differences over SPAN samples, (..., n): they remove offsets, and steady turns, which contain no delay."""
    change: np.ndarray = values[..., SPAN:] - values[..., :-SPAN]
    return change


def _cross_correlation(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Sums of first[i] second[i + k] for k from -LONGEST to LONGEST."""
    around = np.zeros(len(second) + 2 * LONGEST)
    around[LONGEST:-LONGEST] = second
    return np.correlate(around, first)


def _peak(cross: np.ndarray) -> tuple[float, float]:
    """Lag [samples] and value of the peak of largest magnitude, interpolated by a parabola through its neighbours."""
    at = int(np.argmax(np.abs(cross)))
    height = float(cross[at])
    if not 0 < at < len(cross) - 1:
        return float(at - LONGEST), height
    left, right = float(cross[at - 1]), float(cross[at + 1])
    curvature = left - 2.0 * height + right
    shift = 0.5 * (left - right) / curvature if curvature != 0.0 else 0.0
    return at - LONGEST + shift, height - 0.25 * (left - right) * shift
