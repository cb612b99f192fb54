"""Butterworth low-pass of even order, as a cascade of biquads."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import tan
from tierod.methods.filters.each import EachSignal


class Biquad(NamedTuple):
    """Coefficients of (b0 + b1 / z + b2 / z^2) / (1 + a1 / z + a2 / z^2)."""

    b0: Scalar
    b1: Scalar
    b2: Scalar
    a1: Scalar
    a2: Scalar


class Delays(NamedTuple):
    """State of one biquad (transposed direct form II)."""

    first: Scalar
    second: Scalar


@dataclass(frozen=True)
class Butterworth(EachSignal):
    """Low-pass that is flat below its cutoff and falls with 20 dB per decade and order above it.

    Args:
        cutoff: frequency of -3 dB [Hz], below half the sample rate. A lower one removes more noise and delays more: the
            second order has a delay of 0.225 / cutoff seconds at low frequency
        order: even, at least 2

    The other arguments are those of `EachSignal`. Bilinear transform with the cutoff prewarped; the same numbers as
    scipy.signal.butter.

    Source: S. Butterworth, 1930; A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, section 7.2.
    """

    cutoff: Annotated[float, "Hz"]
    order: int = 2

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.order < 2 or self.order % 2:
            raise ParameterError(f"order is {self.order}; expected an even number of at least 2")
        if not 0.0 < self.cutoff < 0.5 / self.sample_time:
            raise ParameterError(
                f"cutoff is {self.cutoff} Hz; expected more than 0 and less than {0.5 / self.sample_time} Hz, "
                f"half the rate that sample_time = {self.sample_time} s gives"
            )

    def sections(self) -> list[Biquad]:
        """The biquads of the cascade, the one with the least damping last."""
        warped = tan(math.pi * self.cutoff * self.sample_time)
        square = warped * warped
        biquads = []
        for k in reversed(range(self.order // 2)):
            damped = 2.0 * math.sin((2 * k + 1) * math.pi / (2 * self.order)) * warped
            scale = 1.0 / (1.0 + damped + square)
            b0 = square * scale
            biquads.append(Biquad(b0, 2.0 * b0, b0, 2.0 * (square - 1.0) * scale, (1.0 - damped + square) * scale))
        return biquads

    def _settled(self, value: Scalar) -> tuple[Delays, ...]:
        return tuple(Delays(value - s.b0 * value, (s.b2 - s.a2) * value) for s in self.sections())

    def _advance(self, memory: tuple[Delays, ...], value: Scalar) -> tuple[tuple[Delays, ...], Scalar]:
        after = []
        for section, delays in zip(self.sections(), memory, strict=True):
            output = section.b0 * value + delays.first
            after.append(
                Delays(
                    section.b1 * value - section.a1 * output + delays.second,
                    section.b2 * value - section.a2 * output,
                )
            )
            value = output
        return tuple(after), value
