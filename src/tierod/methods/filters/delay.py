"""Delay by whole samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from tierod.core.block import Ring, Tree, leaves, rebuild, skeleton
from tierod.core.errors import ParameterError


@dataclass(frozen=True)
class Delay:
    """Every signal as it was `samples` samples ago; what is missing, or lies before the first sample, comes out as NaN.

    Args:
        signals: NamedTuple class of the signals; sample and output
        samples: how many samples late, at least 1
    """

    signals: type
    samples: int

    def __post_init__(self) -> None:
        if self.samples < 1:
            raise ParameterError(f"samples is {self.samples}; expected a delay of at least 1 sample")

    @property
    def Sample(self) -> type:
        """The NamedTuple class of the signals."""
        return self.signals

    def init(self) -> tuple[Ring, ...]:
        """Delay lines that hold nothing yet."""
        return tuple(Ring(self.samples, math.nan) for _ in leaves(skeleton(self.signals)))

    def step(self, state: tuple[Ring, ...], sample: Tree) -> tuple[tuple[Ring, ...], Any]:
        """One sample on."""
        after = tuple(ring.push(value) for ring, (_, value) in zip(state, leaves(sample), strict=True))
        return after, rebuild(skeleton(self.signals), [ring.oldest for ring in state])
