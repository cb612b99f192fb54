"""Exact solutions over a sampling interval: first-order lag, first-order Gauss-Markov noise, damped rotation."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, exp, expm1, maximum

SHORTEST = 1e-4
"""Shortest time constant of a lag [s]: a shorter one is replaced by it, so that nothing is divided by zero. It is far
below a sampling interval."""


class Lagged(NamedTuple):
    """The output of a lag over a sampling interval."""

    mean: Scalar  # over the interval [unit of the input]
    end: Scalar  # at its end [unit of the input]


def lagged_ramp(before: Scalar, after: Scalar, output: Scalar, lag: Scalar, time: Scalar) -> Lagged:
    """Response of a first-order lag to a ramp, exact.

    Args:
        before, after: input at the start and at the end of the sampling interval
        output: of the lag at the start [unit of the input]
        lag: time constant [s]; zero or above
        time: sampling interval [s], above zero

    Validity: time constants below `SHORTEST` are replaced by it.
    Source: solution of lag * y' = u - y with u on a straight line; its mean is that of u - lag * y'.
    """
    lag = maximum(lag, SHORTEST)
    behind = (after - before) * (lag / time)
    end = after - behind + (output - before + behind) * exp(-time / lag)
    return Lagged(0.5 * (before + after) - lag / time * (end - output), end)


def share_reached(elapsed: Number) -> Number:
    """Share of a step that the output of a first-order lag has reached.

    Args:
        elapsed: time since the step over the time constant [-]; zero or above

    Source: solution of lag * y' = u - y with constant u.
    """
    return -expm1(-elapsed)


def gauss_markov_noise(deviation: Scalar, time: Scalar, step: Scalar) -> Scalar:
    """Variance of the process noise of a first-order Gauss-Markov process over a sampling interval.

    Args:
        deviation: its stationary standard deviation [its unit]
        time: its correlation time [s]
        step: sampling interval [s]

    Returns:
        variance of the noise that keeps the stationary deviation [its unit squared]

    Source: P = exp(-2 step / time) P + noise with P = deviation^2.
    """
    return deviation * deviation * share_reached(2.0 * step / time)


LEAST_DAMPING = 1e-4
"""Smallest share of its rate that a body loses over the time [-]. With less damping, the closed form divides the
difference of two nearly equal numbers by almost zero; no real bearing loses less in a hundredth of a second."""


class DampedRotation(NamedTuple):
    """Coefficients of rate and angle increment at the end of the time, for initial rate and torque."""

    kept: Scalar  # rate per initial rate [-]
    path: Scalar  # angle increment per initial rate [s]
    rate_per_torque: Scalar  # [rad/(s*N*m)]
    angle_per_torque: Scalar  # [rad/(N*m)]


def damped_rotation(inertia: Scalar, damping: Scalar, time: Scalar) -> DampedRotation:
    """Transition of a damped rotation under a constant torque, exact.

    Args:
        inertia: [kg*m**2], above zero
        damping: [N*m*s/rad], zero or above
        time: [s], above zero

    Validity: a damping that takes less than `LEAST_DAMPING` of the rate over the time is replaced by one that does.
    Source: solution of inertia * angle'' = torque - damping * angle'.
    """
    damping = maximum(damping, LEAST_DAMPING * inertia / time)
    kept = exp(-damping * time / inertia)
    rate_per_torque = (1.0 - kept) / damping
    path = inertia * rate_per_torque
    return DampedRotation(kept, path, rate_per_torque, (time - path) / damping)
