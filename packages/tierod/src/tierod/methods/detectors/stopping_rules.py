"""Stopping rules and their thresholds for a mean time between false alarms.

Run lengths are in samples, residuals in their standard deviation; `block` turns a rule into a block. Run lengths hold
for white Gaussian residuals; `rule_design.threshold_from_records` finds thresholds for all others.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from statistics import NormalDist

import numpy as np

from tierod.core.errors import ParameterError
from tierod.methods.detectors.control_charts import Cusum, Detector, HeldThreshold, check_sides

WAYS = {"both": (1.0, -1.0), "upper": (1.0,), "lower": (-1.0,)}  # Signs of the changes looked for, by sides
LONGEST = 1e11  # Run length up to which eight digits are correct [samples]
WIDEST = 20_000.0  # Largest threshold for which the equations are solved [standard deviations of a step]
PANEL, POINTS = 5.0, 16  # Width of a panel of the quadrature [steps] and its number of nodes: more change no digit
REACH = 9.5  # Longest step of the chain [standard deviations]; longer ones have a probability of less than 1e-20
_LEAST = 1e-6  # Threshold that is practically none, at which alarms are most frequent


@lru_cache(maxsize=4096)
def cusum_length(mean: float, threshold: float) -> float:
    """Expected number of steps of mean `mean` and deviation 1 until a sum, reset at zero, reaches the threshold.

    The sum is a Markov chain on the nodes of a composite Gauss quadrature. One step leads only to nearby nodes, so that
    the equations are banded. The probability of ending is summed directly, never as one minus the probability of
    continuing, so that no digits are lost however rare the end is. Infinite far beyond `LONGEST`.

    Source: E. S. Page, 1954; D. Brook, D. A. Evans, 1972, doi 10.1093/biomet/59.3.539; quadrature after L. C. Vance,
    1986.
    """
    from scipy.special import ndtr

    if threshold > WIDEST:
        raise ParameterError(
            f"the threshold is {threshold:.3g} standard deviations of a step; expected {WIDEST:g} at most: look for a "
            "larger shift, or allow more false alarms"
        )
    panels = max(math.ceil(threshold / PANEL), 1)
    edge = threshold / panels
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    at = (edge * (np.arange(panels)[:, None] + 0.5 * (nodes + 1.0))).ravel()
    weights = np.tile(0.5 * edge * weights, panels) / math.sqrt(2.0 * math.pi)
    solve = _solver(at, at + mean, weights, min(POINTS * (math.ceil((REACH + abs(mean)) / edge) + 1), len(at) - 1))
    # Of a cycle from zero back to zero: its length, and the probabilities of its end above and below.
    tries = solve(np.column_stack([np.ones(len(at)), ndtr(at + mean - threshold), ndtr(-(at + mean))]))
    length, ended, back = (np.exp(-0.5 * (at - mean) ** 2) * weights) @ tries
    length, ended, back = 1.0 + length, ndtr(mean - threshold) + ended, ndtr(-mean) + back
    found = float(length + back * length / ended) if ended > 0.0 else math.inf
    return found if 0.0 < found < 100.0 * LONGEST else math.inf


def _solver(at: np.ndarray, centre: np.ndarray, weights: np.ndarray, half: int) -> Callable[[np.ndarray], np.ndarray]:
    """Solver of (1 - chain) x = b by a banded LU factorisation."""
    from scipy.linalg.lapack import dgbtrf, dgbtrs

    count = len(at)
    rows = np.arange(-half, half + 1)[:, None] + np.arange(count)
    band = np.zeros((3 * half + 1, count))
    chances = np.exp(-0.5 * (at - centre[np.clip(rows, 0, count - 1)]) ** 2) * weights
    band[half:] = np.where((rows >= 0) & (rows < count), -chances, 0.0)
    band[2 * half] += 1.0
    factors, pivots, _ = dgbtrf(band, half, half, overwrite_ab=True)
    return lambda given: np.asarray(dgbtrs(factors, half, half, given, pivots)[0])


@dataclass(frozen=True)
class StoppingRule(ABC):
    """Base of the rules: a detector with its constant, whose threshold is to be designed."""

    sides: str = field(default="both", kw_only=True)  # "both", "upper" (increases only) or "lower"

    def __post_init__(self) -> None:
        check_sides(self.sides)

    @property
    @abstractmethod
    def name(self) -> str: ...

    @abstractmethod
    def run_length(self, threshold: float, change: float = 0.0) -> float:
        """Expected samples until the alarm, with the mean of the residual shifted by `change` from the start."""

    @abstractmethod
    def block(self, threshold: float, deviation: float, restart: bool = False) -> Detector:
        """The block for residuals of a standard deviation; with `restart` every alarm lasts one sample."""

    def growth(self, threshold: float) -> float:
        """Function of the threshold in which the logarithm of a long run length is linear, for extrapolation."""
        return threshold

    @property
    def longest(self) -> float:
        """Run length up to which `run_length` is accurate [samples]; beyond, the threshold is extrapolated."""
        return LONGEST

    def threshold_for(self, samples: float) -> float:
        """The threshold for a mean number of samples between false alarms.

        Beyond `longest` the logarithm of the run length is extrapolated linearly over `growth`.
        """
        from scipy.optimize import brentq

        if not math.isfinite(samples):
            raise ParameterError(f"{samples} samples between false alarms are not possible; ask for a finite number")
        if samples <= self.run_length(_LEAST):
            raise ParameterError(
                f"{samples:g} samples between false alarms are fewer than a rule without threshold gives; ask for more"
            )
        within = min(samples, self.longest)

        def off(threshold: float) -> float:
            # Limited, since an infinite run length would give the root finder no value to interpolate.
            return math.log(min(self.run_length(threshold), 1e3 * within) / within)

        low, high = self._bracket(off)
        found = float(brentq(off, low, high, xtol=1e-9 * high, rtol=1e-9))
        return found if samples <= self.longest else self._beyond(found, samples)

    def _bracket(self, off: Callable[[float], float]) -> tuple[float, float]:
        low, high = _LEAST, 1.0
        below, above = off(low), off(high)
        while above < 0.0:
            slope = (above - below) / (self.growth(high) - self.growth(low))
            share = (self.growth(high) - 1.01 * above / slope) / self.growth(high)
            low, below = high, above
            high *= min(max(share, 1.02), 2.0)
            above = off(high)
        return low, high

    def _beyond(self, known: float, samples: float) -> float:
        from scipy.optimize import brentq

        near = 0.98 * known
        slope = math.log(self.run_length(known) / self.run_length(near)) / (self.growth(known) - self.growth(near))
        wanted = self.growth(known) + math.log(samples / self.run_length(known)) / slope
        return float(brentq(lambda h: self.growth(h) - wanted, known, 1e3 * known))


@dataclass(frozen=True)
class CusumRule(StoppingRule):
    """Cumulative sum; the delay is shortest where the shift is about twice the drift."""

    drift: float  # subtracted per sample, in standard deviations

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 <= self.drift < math.inf:
            raise ParameterError(f"drift is {self.drift}; expected a number that is not negative")

    @property
    def name(self) -> str:
        return f"CUSUM, drift {self.drift:.3g}"

    def run_length(self, threshold: float, change: float = 0.0) -> float:
        # Two sides are independent detectors, whose rates of alarms add up.
        rate = sum(1.0 / cusum_length(way * change - self.drift, threshold) for way in WAYS[self.sides])
        return 1.0 / rate if rate > 0.0 else math.inf

    def block(self, threshold: float, deviation: float, restart: bool = False) -> Cusum:
        height = threshold * deviation
        return Cusum(self.drift * deviation, height, 2.0 * height, sides=self.sides, restart=restart)


@dataclass(frozen=True)
class HoldRule(StoppingRule):
    """A threshold that must be exceeded in a number of consecutive samples; with 1 a threshold on each sample."""

    hold: int  # number of consecutive samples, at least 1

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (isinstance(self.hold, int) and self.hold >= 1):
            raise ParameterError(f"hold is {self.hold}; expected a whole number of samples, 1 or more")

    @property
    def name(self) -> str:
        return f"threshold held for {self.hold} samples" if self.hold > 1 else "threshold on each sample"

    def run_length(self, threshold: float, change: float = 0.0) -> float:
        # The normal distribution by erfc, accurate far in the tail, where `NormalDist.cdf` gives zero.
        chance = sum(0.5 * math.erfc((threshold - way * change) / math.sqrt(2.0)) for way in WAYS[self.sides])
        if chance <= 1e-300 ** (1.0 / self.hold):
            return math.inf
        return (chance**-self.hold - 1.0) / (1.0 - chance) if chance < 1.0 else float(self.hold)

    def threshold_for(self, samples: float) -> float:
        sides = len(WAYS[self.sides])
        if self.hold > 1 or not 2.0 / sides < samples < math.inf:
            return super().threshold_for(samples)
        return -NormalDist().inv_cdf(1.0 / (sides * samples))

    def growth(self, threshold: float) -> float:
        """Square of the threshold, as in the tail of a Gaussian value."""
        return threshold * threshold

    @property
    def longest(self) -> float:
        """Unlimited in practice, as the run length has a closed form."""
        return 1e300

    def block(self, threshold: float, deviation: float, restart: bool = False) -> HeldThreshold:
        return HeldThreshold(threshold * deviation, self.hold, self.sides, restart)


@dataclass(frozen=True)
class ExcessRule(StoppingRule):
    """Alarm when the excess of values over a level has added up to `excess`; the level is the threshold of this rule.

    With a level set by the smallest fault magnitude, and residuals whose correlation time exceeds the time that the sum
    takes, no sum ever starts in fault-free data. The time between false alarms then depends on the level, over which it
    is measured.
    """

    # sum over values, in standard deviations: one standard deviation for this many values, or a larger excess for fewer
    excess: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.excess < math.inf:
            raise ParameterError(f"excess is {self.excess}; expected a number greater than zero")

    @property
    def name(self) -> str:
        return f"level exceeded by {self.excess:.3g} deviations times values"

    def run_length(self, threshold: float, change: float = 0.0) -> float:
        return CusumRule(threshold, sides=self.sides).run_length(self.excess, change)

    def block(self, threshold: float, deviation: float, restart: bool = False) -> Cusum:
        height = self.excess * deviation
        return Cusum(threshold * deviation, height, 2.0 * height, sides=self.sides, restart=restart)
