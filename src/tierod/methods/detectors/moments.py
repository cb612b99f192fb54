"""Mean and variance of a signal: with exponential forgetting, over batches, or over a moving window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Ring, Scalar, Truth
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, maximum, select, where
from tierod.methods.detectors.value import Value, counts, number
from tierod.physics.lag import share_reached


class Moments(NamedTuple):
    """Mean and variance of the values that counted, and their number."""

    mean: Annotated[float, ""]
    variance: Annotated[float, ""]
    number: Annotated[float, ""]


@dataclass(frozen=True)
class ExponentialMoments:
    """Mean and variance with exponential forgetting; equal weights until a time constant has passed.

    Args:
        time_constant: age at which the weight of a value has fallen to 37 % [s]; a longer one scatters less (the
            variance by sqrt(2 sample_time / time_constant) of itself) and follows a change later
        sample_time: sampling interval [s]

    Missing values, and those not enabled, are left out, and do not age the others.

    Source: D. H. D. West, 1979, doi 10.1145/359146.359153 (incremental form, no difference of large sums).
    """

    time_constant: Annotated[float, "s"]
    sample_time: Annotated[float, "s"]

    Sample = Value
    Output = Moments

    class State(NamedTuple):
        """Mean, variance, and number of values."""

        mean: float
        variance: float
        number: float

    def __post_init__(self) -> None:
        if not (self.time_constant > 0.0 and self.sample_time > 0.0):
            raise ParameterError(
                f"time_constant is {self.time_constant} and sample_time {self.sample_time}; expected both above 0 s"
            )

    def init(self) -> State:
        """State before the first value."""
        return self.State(0.0, 0.0, 0.0)

    def step(self, state: State, sample: Value | Scalar, enabled: Truth = True) -> tuple[State, Moments]:
        """State and output after one value; `enabled` (logic) is whether the value counts."""
        value = number(sample)
        use = counts(value, enabled)
        count = state.number + where(use, 1.0, 0.0)
        # 1 / count gives the plain mean at the start, which would otherwise be biased towards zero.
        share = maximum(share_reached(self.sample_time / self.time_constant), 1.0 / maximum(count, 1.0))
        away = where(use, value - state.mean, 0.0)
        share = where(use, share, 0.0)
        mean = state.mean + share * away
        variance = (1.0 - share) * (state.variance + share * away * away)
        return self.State(mean, variance, count), Moments(mean, variance, count)


@dataclass(frozen=True)
class BatchMoments:
    """Mean and variance of batches of consecutive values; the output is that of the last complete batch.

    Args:
        size: values in a batch, at least 2; a larger one scatters less (the variance by sqrt(2 / size) of itself), and
            updates the output only every `size` values

    Missing values, and those not enabled, are left out and prolong their batch.
    """

    size: int

    Sample = Value

    class State(NamedTuple):
        """Sums of the present batch about its first value, and moments and number of the complete batches."""

        first: float
        sum: float
        squares: float
        number: float
        mean: float
        variance: float
        batches: float

    class Output(NamedTuple):
        """Mean and unbiased variance of the last complete batch, number of batches, and whether one has just ended."""

        mean: Annotated[float, ""]
        variance: Annotated[float, ""]
        batches: Annotated[float, ""]
        updated: Annotated[float, ""]

    def __post_init__(self) -> None:
        if self.size < 2:
            raise ParameterError(f"size is {self.size}; a variance needs a batch of at least 2 values")

    def init(self) -> State:
        """State before the first value."""
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, state: State, sample: Value | Scalar, enabled: Truth = True) -> tuple[State, Output]:
        """State and output after one value; `enabled` (logic) is whether the value counts."""
        value = number(sample)
        use = counts(value, enabled)
        first = where(use, where(state.number < 0.5, value, state.first), state.first)
        away = where(use, value - first, 0.0)
        total, squares = state.sum + away, state.squares + away * away
        count = state.number + where(use, 1.0, 0.0)
        full = count > self.size - 0.5
        mean = where(full, first + total / self.size, state.mean)
        spread = maximum(squares - total * total / self.size, 0.0) / (self.size - 1.0)
        variance = where(full, spread, state.variance)
        updated = where(full, 1.0, 0.0)
        after = self.State(
            first,
            where(full, 0.0, total),
            where(full, 0.0, squares),
            where(full, 0.0, count),
            mean,
            variance,
            state.batches + updated,
        )
        return after, self.Output(mean, variance, after.batches, updated)


class _Sums(NamedTuple):
    """Number, sum and sum of squares of values about a reference."""

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
        """State before the first value: an empty window."""
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
    """The sums about a reference that is moved by `shift`."""
    total = sums.sum - sums.number * shift
    return _Sums(sums.number, total, sums.squares - shift * (sums.sum + total))
