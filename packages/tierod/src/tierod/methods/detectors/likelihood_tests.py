"""Tests of a shifted mean by likelihood ratios: sequential, and generalised over moving windows."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Ring, Scalar, Tree, Truth
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, either, maximum, select, where
from tierod.methods.detectors.control_charts import Detector, Value, counts, number


class Moments(NamedTuple):
    """Mean and variance of the values that counted, and their number."""

    mean: Annotated[float, ""]
    variance: Annotated[float, ""]
    number: Annotated[float, ""]


class _Sums(NamedTuple):
    number: Scalar
    sum: Scalar
    squares: Scalar

    def changed(self, weight: Scalar, away: Scalar) -> _Sums:
        """The sums with one value added (weight 1), removed (-1), or unchanged (0)."""
        step = weight * away
        return _Sums(self.number + weight, self.sum + step, self.squares + step * away)


@dataclass(frozen=True)
class MovingMoments:
    """Mean and variance over the last `size` samples.

    Args:
        size: samples in the window, at least 2; a larger one scatters less (the variance by sqrt(2 / size) of itself)
            and follows a change later

    Missing values, and those not enabled, take their place in the window but do not count in it. The running sums are
    replaced by fresh ones once per window, about the mean of the last one, so that rounding errors do not accumulate, a
    small variance stays accurate beside a large mean, and the rounding error of a huge spike is gone within three
    windows.
    """

    size: int

    Sample = Value
    Output = Moments

    class State(NamedTuple):
        """Values of the window and whether they count, its sums about `reference`, and the sums that replace them."""

        values: Ring
        weights: Ring
        reference: float
        window: _Sums
        fresh: _Sums
        age: float

    def __post_init__(self) -> None:
        if self.size < 2:
            raise ParameterError(f"size is {self.size}; a variance needs a window of at least 2 samples")

    def init(self) -> State:
        empty = _Sums(0.0, 0.0, 0.0)
        return self.State(Ring(self.size), Ring(self.size), 0.0, empty, empty, 0.0)

    def step(self, state: State, sample: Value | Scalar, enabled: Truth = True) -> tuple[State, Moments]:
        """State and output after one value; `enabled` (logic) is whether the value counts."""
        raw = number(sample)
        use = counts(raw, enabled)
        weight = where(use, 1.0, 0.0)
        # The first value of an empty window becomes the reference, so that the sums hold small differences.
        empty = state.window.number < 0.5
        reference = where(both(empty, use), raw, state.reference)
        value = where(use, raw, reference)
        window = _Sums(*(where(empty, 0.0, total) for total in state.window))
        window = window.changed(-state.weights.oldest, state.values.oldest - reference)
        window = window.changed(weight, value - reference)
        fresh = state.fresh.changed(weight, value - reference)
        age = state.age + 1.0
        whole = age > self.size - 0.5
        window = select(whole, fresh, window)
        shift = where(whole, window.sum / maximum(window.number, 1.0), 0.0)
        moments = self._moments(window, reference)
        window = _moved(window, shift)
        fresh = _Sums(*(where(whole, 0.0, value) for value in fresh))
        after = self.State(
            state.values.push(value),
            state.weights.push(weight),
            reference + shift,
            window,
            fresh,
            where(whole, 0.0, age),
        )
        return after, moments

    @staticmethod
    def _moments(sums: _Sums, reference: Scalar) -> Moments:
        share = 1.0 / maximum(sums.number, 1.0)
        spread = maximum(sums.squares - sums.sum * sums.sum * share, 0.0)
        return Moments(reference + sums.sum * share, spread / maximum(sums.number - 1.0, 1.0), sums.number)


def _moved(sums: _Sums, shift: Scalar) -> _Sums:
    total = sums.sum - sums.number * shift
    return _Sums(sums.number, total, sums.squares - shift * (sums.sum + total))


@dataclass(frozen=True)
class SequentialTest:
    """Test of a shifted mean against a mean of zero that decides as soon as the evidence suffices.

    The log-likelihood ratio grows by shift / deviation^2 (value - shift / 2) per value. At `upper` the test decides for
    the shift, at `lower` against it; then it restarts from zero.

    Args:
        shift: of the mean to be detected, with its sign [unit of the residual]
        deviation: standard deviation of the residual [same unit]
        upper: evidence for the shift at which the alarm is raised; ln((1 - missed) / false alarms) for one test
        lower: evidence against the shift, below zero; ln(missed / (1 - false alarms))

    A missing value, or one that is not enabled, leaves the evidence unchanged.

    Source: A. Wald, 1945, doi 10.1214/aoms/1177731118.
    """

    shift: Annotated[float, "unit of the signal"]
    deviation: Annotated[float, "unit of the signal"]
    upper: Annotated[float, ""]
    lower: Annotated[float, ""]

    Sample = Value

    class State(NamedTuple):
        """Accumulated log-likelihood ratio."""

        evidence: float

    class Output(NamedTuple):
        """Evidence, alarm (1.0 on a decision for the shift), decision (1.0 shift, -1.0 no shift, 0.0 none yet)."""

        evidence: Annotated[float, ""]
        alarm: Annotated[float, ""]
        decision: Annotated[float, ""]

    def __post_init__(self) -> None:
        if self.shift == 0.0 or not self.deviation > 0.0:
            raise ParameterError(
                f"shift is {self.shift} and deviation {self.deviation}; expected a shift and a deviation above zero"
            )
        if not self.lower < 0.0 < self.upper:
            raise ParameterError(f"lower is {self.lower} and upper {self.upper}; expected lower below 0 below upper")

    def init(self) -> State:
        return self.State(0.0)

    def step(self, state: State, sample: Value | Scalar, enabled: Truth = True) -> tuple[State, Output]:
        """State and output after one value; `enabled` (logic) is whether the value counts."""
        value = number(sample)
        slope = self.shift / (self.deviation * self.deviation)
        evidence = state.evidence + where(counts(value, enabled), slope * (value - 0.5 * self.shift), 0.0)
        shifted, fault_free = evidence >= self.upper, evidence <= self.lower
        decision = where(shifted, 1.0, where(fault_free, -1.0, 0.0))
        after = where(either(shifted, fault_free), 0.0, evidence)
        return self.State(after), self.Output(evidence, where(shifted, 1.0, 0.0), decision)


@dataclass(frozen=True)
class TwoSided:
    """Alarm when one of two detectors alarms."""

    up: Detector  # up, down: detectors with an output `alarm`
    down: Detector

    Sample = Value

    class Output(NamedTuple):
        """Whether one of the detectors alarms (1.0) or neither (0.0)."""

        alarm: Annotated[float, ""]

    def init(self) -> tuple[Tree, Tree]:
        return self.up.init(), self.down.init()

    def step(
        self, state: tuple[Tree, Tree], sample: Value | Scalar, enabled: Truth = True
    ) -> tuple[tuple[Tree, Tree], Output]:
        """State and output after one value; `enabled` (logic) is whether the value counts."""
        up, above = self.up.step(state[0], sample, enabled)
        down, below = self.down.step(state[1], sample, enabled)
        return (up, down), self.Output(maximum(above.alarm, below.alarm))


WINDOWS = (4, 8, 16, 32, 64, 128)
"""Lengths of the windows [samples]; for a shift of a length between two of them up to 1 - sqrt(1/2), 29 %, of the
evidence is lost."""


@dataclass(frozen=True)
class LikelihoodRatio:
    """Alarm when the mean of a residual over one of several windows differs significantly from zero.

    For each window of n values with mean m the evidence is n m^2 / (2 deviation^2), the log-likelihood ratio at the
    maximum-likelihood shift; the output is the largest.

    Args:
        deviation: standard deviation of the residual [unit of the residual]
        windows: lengths [samples]

    An alarm does not reset the windows: it lasts until the shift has left them. Missing values, and those not enabled,
    are left out.

    Source: A. S. Willsky, H. L. Jones, 1976, doi 10.1109/TAC.1976.1101146; windows after T. L. Lai, 1995.
    """

    deviation: Annotated[float, "unit of the signal"]
    threshold: Annotated[float, ""]
    windows: tuple[int, ...] = WINDOWS
    moments: tuple[MovingMoments, ...] = field(init=False, repr=False)

    Sample = Value

    class Output(NamedTuple):
        """Largest evidence, the mean of the window that gives it, and whether it reaches the threshold (1.0)."""

        evidence: Annotated[float, ""]
        shift: Annotated[float, ""]
        alarm: Annotated[float, ""]

    def __post_init__(self) -> None:
        if not (self.deviation > 0.0 and self.threshold > 0.0):
            raise ParameterError(
                f"deviation is {self.deviation} and threshold {self.threshold}; expected both greater than zero"
            )
        if not self.windows or list(self.windows) != sorted(set(self.windows)):
            raise ParameterError(f"windows is {self.windows}; expected lengths that rise, each given once")
        object.__setattr__(self, "moments", tuple(MovingMoments(size) for size in self.windows))

    def init(self) -> tuple[MovingMoments.State, ...]:
        return tuple(moments.init() for moments in self.moments)

    def step(
        self, state: tuple[MovingMoments.State, ...], sample: Value | Scalar, enabled: Truth = True
    ) -> tuple[tuple[MovingMoments.State, ...], Output]:
        """State and output after one value; `enabled` (logic) is whether the value counts."""
        after, evidence, shift = [], 0.0, 0.0
        for moments, held in zip(self.moments, state, strict=True):
            advanced, found = moments.step(held, sample, enabled)
            after.append(advanced)
            own = 0.5 * found.number * (found.mean / self.deviation) * (found.mean / self.deviation)
            shift = where(own > evidence, found.mean, shift)
            evidence = maximum(evidence, own)
        return tuple(after), self.Output(evidence, shift, where(evidence >= self.threshold, 1.0, 0.0))
