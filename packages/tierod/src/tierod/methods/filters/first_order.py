"""First-order low-pass, and a causal derivative based on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, derived
from tierod.core.errors import ParameterError
from tierod.methods.filters.each import EachSignal
from tierod.physics.lag import share_reached


def _require_time_constant(value: float) -> None:
    if not value > 0.0:
        raise ParameterError(f"time_constant is {value}; expected a time greater than zero [s]")


@dataclass(frozen=True)
class FirstOrderLowPass(EachSignal):
    """First-order low-pass y' = (u - y) / time_constant, exact for an input that is constant over a sampling interval.

    Args:
        time_constant: time to 63 % of a step [s]; a longer one removes more noise and delays by as much

    The other arguments are those of `EachSignal`.
    """

    time_constant: Annotated[float, "s"]

    def __post_init__(self) -> None:
        super().__post_init__()
        _require_time_constant(self.time_constant)

    def _settled(self, value: Scalar) -> Scalar:
        return value

    def _advance(self, memory: Scalar, value: Scalar) -> tuple[Scalar, Scalar]:
        output = memory + share_reached(self.sample_time / self.time_constant) * (value - memory)
        return output, output


class Smoothed(NamedTuple):
    """State of one derivative: the low-passed signal."""

    smooth: Scalar


@dataclass(frozen=True)
class Differentiator(EachSignal):
    """Causal derivative: rate of change of the signal after a first-order low-pass; starts at zero.

    Args:
        time_constant: of the low-pass [s]; a longer one reduces the noise of the result and increases its delay

    The other arguments are those of `EachSignal`; the output has the signals' names and their units per second.
    """

    time_constant: Annotated[float, "s"]

    def __post_init__(self) -> None:
        super().__post_init__()
        _require_time_constant(self.time_constant)

    @property
    def Output(self) -> type:
        """The NamedTuple class of the derivatives."""
        return _per_second(self.signals)

    def _settled(self, value: Scalar) -> Smoothed:
        return Smoothed(value)

    def _advance(self, memory: Smoothed, value: Scalar) -> tuple[Smoothed, Scalar]:
        change = share_reached(self.sample_time / self.time_constant) * (value - memory.smooth)
        return Smoothed(memory.smooth + change), change / self.sample_time


@lru_cache(maxsize=256)
def _per_second(signals: type) -> type:
    rates: type = derived(signals, "Rates", "({})/s")
    return rates
