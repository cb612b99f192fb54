"""Stopping rules and their thresholds for a mean time between false alarms.

Run lengths are in samples, residuals in their standard deviation; `block` turns a rule into a block. Run lengths hold
for white Gaussian residuals; `tierod.methods.detectors.measured` finds thresholds for all others."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from statistics import NormalDist

import numpy as np

from tierod.core.errors import ParameterError
from tierod.methods.detectors.control_charts import Cusum, Detector, GeometricAverage, HeldThreshold, check_sides
from tierod.methods.detectors.likelihood_tests import WINDOWS, LikelihoodRatio, SequentialTest, TwoSided
from tierod.methods.detectors.random_walk import LONGEST, Walk
from tierod.methods.detectors.random_walk import run_length as walked

WAYS = {"both": (1.0, -1.0), "upper": (1.0,), "lower": (-1.0,)}
"""Signs of the changes that a detector looks for, by its sides."""

_LEAST = 1e-6  # Threshold that is practically none, at which alarms are most frequent


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

    def scale(self, deviation: float) -> float:
        """Factor from this threshold to that of residuals of a standard deviation [their unit]; 1 for evidence."""
        return deviation

    def growth(self, threshold: float) -> float:
        """Function of the threshold in which the logarithm of a long run length is linear, for extrapolation."""
        return threshold

    @property
    def longest(self) -> float:
        """Run length up to which `run_length` is accurate [samples]; beyond, the threshold is extrapolated."""
        return LONGEST

    @property
    def unit(self) -> float:
        """A small threshold, at which alarms are frequent."""
        return 1.0

    def alarms(self, flags: np.ndarray) -> int:
        """Number of alarms in the flags of a block with `restart`, (n,)."""
        return int(flags.sum())

    def threshold_for(self, samples: float) -> float:
        """The threshold for a mean number of samples between false alarms.

        Beyond `longest` the logarithm of the run length is extrapolated linearly over `growth`.

        Raises:
            ParameterError: so few samples that no threshold is needed, or not a finite number
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
        low, high = _LEAST, self.unit
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
        """Expected samples until the alarm, with the mean shifted by `change`."""
        means = [way * change - self.drift for way in WAYS[self.sides]]
        return together([walked(Walk(0.0, threshold, True, 1.0, mean, 1.0)) for mean in means])

    def block(self, threshold: float, deviation: float, restart: bool = False) -> Cusum:
        height = threshold * deviation
        return Cusum(self.drift * deviation, height, 2.0 * height, sides=self.sides, restart=restart)


@dataclass(frozen=True)
class AverageRule(StoppingRule):
    """Geometric moving average; with weight 1 a threshold on each sample."""

    weight: float  # of the newest value, 0 to 1

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.weight <= 1.0:
            raise ParameterError(f"weight is {self.weight}; expected more than 0 and at most 1")

    @property
    def name(self) -> str:
        return f"geometric average, weight {self.weight:.3g}" if self.weight < 1.0 else "threshold on each sample"

    def run_length(self, threshold: float, change: float = 0.0) -> float:
        """Expected samples until the alarm, with the mean shifted by `change`."""
        if self.weight == 1.0:
            return self._each_sample(threshold, change)
        way = WAYS[self.sides][0]
        # One-sided: the lower limit is so low that the average never reaches it.
        lower = -threshold if self.sides == "both" else min(-threshold, way * change) - 9.0 * self.unit
        return walked(Walk(lower, threshold, False, 1.0 - self.weight, self.weight * way * change, self.weight))

    def _each_sample(self, threshold: float, change: float) -> float:
        chances = [max(_chance_below(way * change - threshold), 1e-300) for way in WAYS[self.sides]]
        return together([1.0 / chance for chance in chances])

    def growth(self, threshold: float) -> float:
        """Square of the threshold, as in the tail of a Gaussian average."""
        return threshold * threshold

    @property
    def longest(self) -> float:
        """Run length up to which `run_length` is accurate [samples]; weight 1 has a closed form."""
        return LONGEST if self.weight < 1.0 else 1e300

    @property
    def unit(self) -> float:
        """Standard deviation of the average, at which alarms are frequent."""
        return math.sqrt(self.weight / (2.0 - self.weight))

    def block(self, threshold: float, deviation: float, restart: bool = False) -> GeometricAverage:
        return GeometricAverage(self.weight, threshold * deviation, self.sides, restart)


@dataclass(frozen=True)
class HoldRule(StoppingRule):
    """A threshold that must be exceeded in a number of consecutive samples."""

    hold: int  # number of consecutive samples, at least 1

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (isinstance(self.hold, int) and self.hold >= 1):
            raise ParameterError(f"hold is {self.hold}; expected a whole number of samples, 1 or more")

    @property
    def name(self) -> str:
        return f"threshold held for {self.hold} samples"

    def run_length(self, threshold: float, change: float = 0.0) -> float:
        """Expected samples until the alarm, with the mean shifted by `change`."""
        chance = sum(_chance_below(way * change - threshold) for way in WAYS[self.sides])
        if chance <= 1e-300 ** (1.0 / self.hold):
            return math.inf
        return (chance**-self.hold - 1.0) / (1.0 - chance) if chance < 1.0 else float(self.hold)

    def threshold_for(self, samples: float) -> float:
        """The threshold for a mean number of samples between false alarms.

        Raises:
            ParameterError: so few samples that no threshold is needed, or not a finite number
        """
        sides = len(WAYS[self.sides])
        if self.hold > 1 or not 2.0 / sides < samples < math.inf:
            return super().threshold_for(samples)
        return -NormalDist().inv_cdf(1.0 / (sides * samples))

    def growth(self, threshold: float) -> float:
        """Square of the threshold, as in the tail of a Gaussian value."""
        return threshold * threshold

    @property
    def longest(self) -> float:
        """Run length up to which `run_length` is accurate [samples]: unlimited in practice, as it has a closed form."""
        return 1e300

    def block(self, threshold: float, deviation: float, restart: bool = False) -> HeldThreshold:
        return HeldThreshold(threshold * deviation, self.hold, self.sides, restart)


@dataclass(frozen=True)
class SequentialRule(StoppingRule):
    """Repeated sequential probability ratio test; its threshold is the evidence for the shift."""

    shift: float  # to be detected, in standard deviations, greater than zero
    lower: float = math.log(0.01)  # evidence against the shift that ends a test, below zero; ln(missed) of one test

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (0.0 < self.shift < math.inf and -math.inf < self.lower < 0.0):
            raise ParameterError(
                f"shift is {self.shift} and lower {self.lower}; expected a shift above zero and lower below 0"
            )

    @property
    def name(self) -> str:
        return f"sequential test, shift {self.shift:.3g}"

    def scale(self, deviation: float) -> float:
        """1, since the threshold is evidence."""
        return 1.0

    def run_length(self, threshold: float, change: float = 0.0) -> float:
        """Expected samples until the alarm, with the mean shifted by `change`."""
        drifts = [self.shift * (way * change - 0.5 * self.shift) for way in WAYS[self.sides]]
        return together([walked(Walk(self.lower, threshold, True, 1.0, drift, self.shift)) for drift in drifts])

    def block(self, threshold: float, deviation: float, restart: bool = False) -> Detector:
        """The block for residuals of a standard deviation: one test, or two for both sides."""
        up, down = (
            SequentialTest(way * self.shift * deviation, deviation, threshold, self.lower) for way in (1.0, -1.0)
        )
        rules: dict[str, Detector] = {"both": TwoSided(up, down), "upper": up, "lower": down}
        return rules[self.sides]


@dataclass(frozen=True)
class LikelihoodRatioRule(StoppingRule):
    """Generalised likelihood ratio over windows, for shifts of unknown size; its run length has no closed form."""

    windows: tuple[int, ...] = WINDOWS  # their lengths [samples]

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sides != "both":
            raise ParameterError(
                f"sides is '{self.sides}'; the likelihood ratio finds shifts of either sign: give 'both'"
            )

    @property
    def name(self) -> str:
        return f"likelihood ratio over {self.windows[0]} to {self.windows[-1]} samples"

    def scale(self, deviation: float) -> float:
        """1, since the threshold is evidence."""
        return 1.0

    def run_length(self, threshold: float, change: float = 0.0) -> float:
        """Not available: it has no closed form.

        Raises:
            ParameterError: always; `tierod.methods.detectors.measured` finds a threshold, also on simulated residuals
        """
        raise ParameterError("a likelihood ratio has no run length in closed form; measure it on healthy residuals")

    def block(self, threshold: float, deviation: float, restart: bool = False) -> LikelihoodRatio:
        """The block for residuals of a standard deviation; it does not restart, so the onsets of alarms are counted."""
        return LikelihoodRatio(deviation, threshold, self.windows)

    def alarms(self, flags: np.ndarray) -> int:
        """Number of onsets of alarms in the flags of a block, (n,)."""
        return int(np.count_nonzero(np.diff(flags, prepend=0.0) > 0.5))


def _chance_below(value: float) -> float:
    """Standard normal distribution function, accurate far in the tail, where `NormalDist.cdf` gives zero."""
    return 0.5 * math.erfc(-value / math.sqrt(2.0))


def together(lengths: Sequence[float]) -> float:
    """Expected samples until the first of several independent detectors alarms, from those of each."""
    rate = sum(1.0 / length for length in lengths)
    return 1.0 / rate if rate > 0.0 else math.inf


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
        """Expected samples until the alarm, for white residuals."""
        return CusumRule(threshold, sides=self.sides).run_length(self.excess, change)

    def block(self, threshold: float, deviation: float, restart: bool = False) -> Cusum:
        height = self.excess * deviation
        return Cusum(threshold * deviation, height, 2.0 * height, sides=self.sides, restart=restart)
