"""Variance over a window that moves on by whole blocks of samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, maximum, present, select, where


class Moments(NamedTuple):
    """Number, mean, and sum of squared deviations of a set of samples."""

    number: Scalar
    mean: Scalar
    squares: Scalar


_NONE = Moments(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RollingVariance:
    """Variance of the counted samples of the last `blocks` whole blocks.

    Each block has its own moments, which are merged instead of running sums, so that rounding does not accumulate. The
    result changes once per block. The window is one of time: a block without counted samples still replaces the oldest.

    Args:
        block_samples: samples per block, counted or not
        blocks: blocks per window

    Source: merging after Chan, Golub, LeVeque, The American Statistician 37 (1983) 242.
    """

    block_samples: int
    blocks: int

    class Sample(NamedTuple):
        """A value and whether it counts; NaN never counts."""

        value: float
        counted: Annotated[float, ""]

    class State(NamedTuple):
        """Samples of the present block, its moments, those of the window's blocks, oldest first, and all merged."""

        seen: Scalar
        present: Moments
        window: tuple[Moments, ...]
        merged: Moments

    class Spread(NamedTuple):
        """Variance over the window (0 below two samples), and number of samples behind it."""

        variance: float
        samples: Annotated[float, ""]

    def __post_init__(self) -> None:
        if self.block_samples < 1 or self.blocks < 1:
            raise ParameterError(
                f"a window of {self.blocks} blocks of {self.block_samples} samples is empty; give at least 1 of each"
            )

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, _NONE, (_NONE,) * self.blocks, _NONE)

    def step(self, state: State, sample: Sample) -> tuple[State, Spread]:
        """Process one sample."""
        counted = both(sample.counted > 0.0, present(sample.value))
        moments = _with(state.present, where(counted, sample.value, 0.0), counted)
        seen = state.seen + 1.0
        full = seen >= float(self.block_samples)
        moved = (*state.window[1:], moments)
        window = select(full, moved, state.window)
        merged = _NONE
        for block in window:
            merged = _merge(merged, block)
        after = self.State(where(full, 0.0, seen), select(full, _NONE, moments), window, merged)
        enough = merged.number >= 2.0
        variance = merged.squares / where(enough, merged.number - 1.0, 1.0)
        return after, self.Spread(where(enough, variance, 0.0), merged.number)


def _with(moments: Moments, value: Scalar, counted: Scalar) -> Moments:
    count = moments.number + 1.0
    away = value - moments.mean
    mean = moments.mean + away / count
    added = Moments(count, mean, moments.squares + away * (value - mean))
    return select(counted, added, moments)


def _merge(a: Moments, b: Moments) -> Moments:
    count = a.number + b.number
    away, share = b.mean - a.mean, b.number / maximum(count, 1.0)
    return Moments(count, a.mean + away * share, a.squares + b.squares + away * away * a.number * share)
