"""Linear motions solved exactly over a sample: a lag of the first order, noise that it shapes, a damped rotation."""

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
    """Response of a lag of the first order to a ramp, exact.

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


LEAST_DAMPING = 1e-4
"""Share of its rate that a body loses at least over the time: with less the difference of two near numbers is divided
by next to nothing; it is a ten-thousandth of the rate, which no bearing keeps better in a hundredth of a second."""


class DampedRotation(NamedTuple):
    """Transition of angle and rate over the time, from rate and torque.

    Args:
        kept: rate per rate before [-]
        path: angle per rate before [s]
        rate_per_torque: [rad/(s*N*m)]
        angle_per_torque: [rad/(N*m)]
    """

    kept: Scalar
    path: Scalar
    rate_per_torque: Scalar
    angle_per_torque: Scalar


def damped_rotation(inertia: Scalar, damping: Scalar, time: Scalar) -> DampedRotation:
    """The motion of a damped body under a constant torque, exact.

    Args:
        inertia: [kg*m**2], above zero
        damping: [N*m*s/rad], zero or above
        time: [s], above zero

    Validity: a damping of less than `LEAST_DAMPING` over the time counts as that much.
    Source: solution of inertia * angle'' = torque - damping * angle'.
    """
    damping = maximum(damping, LEAST_DAMPING * inertia / time)
    kept = exp(-damping * time / inertia)
    rate_per_torque = (1.0 - kept) / damping
    path = inertia * rate_per_torque
    return DampedRotation(kept, path, rate_per_torque, (time - path) / damping)
