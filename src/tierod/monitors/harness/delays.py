"""Delay and gain between signals that follow each other, over a whole drive: cross-correlation block by block."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

RATE = 50.0
"""Samples per second that are compared [Hz]: steering moves below 5 Hz, and the peak is interpolated."""

BLOCK = 1024
"""Samples of one comparison, 20 s: many turns of the wheel, and a missing sample costs no more than that."""

LONGEST = 50
"""Largest delay that is looked for, in samples: one second."""


SPAN = 20
"""Samples of the change that is compared, 0.4 s: emphasises 0.4 to 2 Hz, where drivers steer and cars follow."""


@dataclass(frozen=True)
class Lag:
    """Lag of one signal behind another.

    Args:
        delay: of the second against the first; negative where the first is late [s]
        deviation: its standard deviation, from block to block [s]
        correlation: of their changes at that delay
        gain: of the second over the first, slow turns included
        gain_correlation: of the two without regard to the delay
        seconds: compared [s]
    """

    delay: Annotated[float, "s"]
    deviation: Annotated[float, "s"]
    correlation: float
    gain: float
    gain_correlation: float
    seconds: Annotated[float, "s"]


@dataclass
class LagOverDrive:
    """Sums over the blocks of a drive; the result does not depend on how the recording is cut.

    Args:
        smallest: root mean square of the first signal's change over SPAN that a block needs [its unit]: below it noise
            is compared
    """

    smallest: float
    _cross: np.ndarray = field(default_factory=lambda: np.zeros(2 * LONGEST + 1))
    _powers: np.ndarray = field(default_factory=lambda: np.zeros(2))
    _slow: np.ndarray = field(default_factory=lambda: np.zeros((2, 2)))
    _delays: list[tuple[float, float]] = field(default_factory=list)

    def add(self, first: np.ndarray, second: np.ndarray) -> None:
        """One block of both signals, (BLOCK,) each; a block with missing samples is left out."""
        both = np.array([first, second])
        if not np.isfinite(both).all():
            return
        first, second = _change(both)
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
        """Lag over the drive; None where it was too short or the signals do not follow each other."""
        norm, slow = math.sqrt(self._powers.prod()), self._slow
        if len(self._delays) < 2 or not norm > 0.0:
            return None
        lag, height = _peak(self._cross)
        delays, weights = np.array(self._delays).T
        # From block to block, weighed as the sums weigh them; no better than a tenth of a sample.
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
    """Change over SPAN samples, (..., n): a steady turn holds no information on a delay, and offsets vanish."""
    change: np.ndarray = values[..., SPAN:] - values[..., :-SPAN]
    return change


def _cross_correlation(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Sums of first[i] second[i + k] for k from -LONGEST to LONGEST."""
    around = np.zeros(len(second) + 2 * LONGEST)
    around[LONGEST:-LONGEST] = second
    return np.correlate(around, first)


def _peak(cross: np.ndarray) -> tuple[float, float]:
    """Place [samples] and height of the largest magnitude, by a parabola through it and its neighbours."""
    at = int(np.argmax(np.abs(cross)))
    height = float(cross[at])
    if not 0 < at < len(cross) - 1:
        return float(at - LONGEST), height
    left, right = float(cross[at - 1]), float(cross[at + 1])
    curvature = left - 2.0 * height + right
    shift = 0.5 * (left - right) / curvature if curvature != 0.0 else 0.0
    return at - LONGEST + shift, height - 0.25 * (left - right) * shift
