"""Adaptation of noises to a drive: innovations that keep their sign show a model error longer than a sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import both, exp, limit, maximum, present, where

LEAST_VARIANCE = 1e-18
"""Floor of the expected variance, which keeps the ratio finite for a filter without noise, in the squared unit of the
reading."""


class ScaleState(NamedTuple):
    """Low-passed innovation, and the natural logarithm of the scale."""

    innovation: Annotated[Scalar, ""]
    logarithm: Annotated[Scalar, ""]


@dataclass(frozen=True)
class NoiseScale:
    """Adaptive factor of a noise variance, from the innovations of one reading.

    Innovations of a consistent filter are white: their low-pass has the expected variance times share / (2 - share).
    Model errors last longer than a sample, so that the low-pass has more. The scale rises while it has more and falls
    while it has less, until the larger noise makes the innovations white. It rises faster than it falls, so that it
    settles on the cautious side: with the default times where the filter expects 2.6 times the observed variance. It
    never falls below one: the given noise is the minimum.

    Args:
        sample_time: sampling interval
        memory: time constant of the low-pass; shorter errors count as noise
        rise, fall: times in which the logarithm rises and falls by one
        most: largest relative excess that counts in one sample
        greatest: upper bound of the logarithm

    Valid for a reading with white noise; errors slower than the filter's own unknowns are left to those.
    Source: whiteness of innovations, R. K. Mehra, IEEE Trans. Automatic Control 15 (1970) 175, as a stochastic
    approximation instead of from autocorrelations over a record.
    """

    sample_time: Annotated[float, "s", POSITIVE]
    memory: Annotated[float, "s", POSITIVE] = 0.2
    rise: Annotated[float, "s", POSITIVE] = 1.0
    fall: Annotated[float, "s", POSITIVE] = 10.0
    most: Annotated[float, "", POSITIVE] = 4.0
    greatest: Annotated[float, "", NOT_NEGATIVE] = 9.0

    def init(self) -> ScaleState:
        """State before the first sample: the noise as given."""
        return ScaleState(0.0, 0.0)

    def scale(self, state: ScaleState) -> Scalar:
        """Factor of the variance."""
        return exp(state.logarithm)

    def after(self, state: ScaleState, innovation: Scalar, variance: Scalar, running: Scalar) -> ScaleState:
        """State after one sample; held where the reading is missing or the filter does not run.

        Args:
            state: state of the previous sample
            innovation: measured less predicted [unit of the reading]
            variance: its variance as predicted by the filter [its square]
            running: whether the filter ran
        """
        share = self.sample_time / (self.memory + self.sample_time)
        usable = both(running, present(innovation))
        smoothed = state.innovation + share * (where(usable, innovation, 0.0) - state.innovation)
        expected = maximum(variance * share / (2.0 - share), LEAST_VARIANCE)
        excess = limit(smoothed * smoothed / expected - 1.0, -1.0, self.most)
        moved = state.logarithm + self.sample_time * excess / where(excess > 0.0, self.rise, self.fall)
        return ScaleState(
            where(usable, smoothed, state.innovation),
            where(usable, limit(moved, 0.0, self.greatest), state.logarithm),
        )
