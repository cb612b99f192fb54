"""A lag of the first order: its step response, its answer to a ramp, and noise that it shapes."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, exp, expm1, maximum

SHORTEST = 1e-4
"""Lag below which it counts as this long [s]: far below a sample, and nothing is divided by zero."""


class Lagged(NamedTuple):
    """The output of a lag over a sample.

    Args:
        mean: over the sample [unit of the input]
        end: at its end [unit of the input]
    """

    mean: Scalar
    end: Scalar


def lagged_ramp(before: Scalar, after: Scalar, output: Scalar, lag: Scalar, time: Scalar) -> Lagged:
    """What a lag of the first order makes of a ramp, exact.

    Args:
        before, after: input at the start and at the end of the sample
        output: of the lag at the start [unit of the input]
        lag: time constant [s]; zero or above
        time: of the sample [s], above zero

    Validity: lags of less than `SHORTEST` count as that.
    Source: solution of lag * y' = u - y with u on a straight line; its mean is that of u - lag * y'.
    """
    lag = maximum(lag, SHORTEST)
    behind = (after - before) * (lag / time)
    end = after - behind + (output - before + behind) * exp(-time / lag)
    return Lagged(0.5 * (before + after) - lag / time * (end - output), end)


def share_reached(elapsed: Number) -> Number:
    """Share of a step that a lag of the first order has followed.

    Args:
        elapsed: time since the step over the time constant [-]; zero or above

    Source: solution of lag * y' = u - y with constant u.
    """
    return -expm1(-elapsed)


def gauss_markov_noise(deviation: Scalar, time: Scalar, step: Scalar) -> Scalar:
    """Variance that a Gauss-Markov process of the first order gains in a sample.

    Args:
        deviation: its stationary standard deviation [its unit]
        time: its correlation time [s]
        step: of the sample [s]

    Returns:
        variance of the driving noise, which keeps the stationary deviation [its unit squared]

    Source: P = exp(-2 step / time) P + noise with P = deviation^2.
    """
    return deviation * deviation * share_reached(2.0 * step / time)
