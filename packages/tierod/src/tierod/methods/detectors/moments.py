"""Mean and variance of a signal over a moving window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Ring, Scalar, Truth
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, maximum, select, where
from tierod.methods.detectors.value import Value, counts, number


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
