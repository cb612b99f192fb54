"""Dry friction by Coulomb and Dahl, and linear motions solved exactly over a sample.

Arguments, unless a function says otherwise: angle_increment [rad], without reversal inside; dahl_angle: level over
initial stiffness [rad], positive; damping [N*m*s/rad], zero or above; deviation: its stationary standard deviation [its
unit]; direction: sign of the rate [-]; elapsed: time since the step over the time constant [-]; zero or above;
exponent: alpha, shape of the build-up [-]; 1 exponential, below 1 steeper, above 1 longer tail; inertia [kg*m**2],
above zero; lag: time constant [s]; zero or above; level: friction torque while moving [N*m]; normalised: friction
torque over its level before the increment [-]; output: of the lag at the start [unit of the input]; rate: angular rate
[rad/s]; sensitivity: dh / d ln(dahl_angle) before the increment [-]; step: sampling interval [s]; time: sampling
interval [s], above zero; width: rate at which 76 % of the level is reached [rad/s]; a smaller one lets a filter
chatter, with a larger one the model creeps at low rates.
"""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, absolute, exp, expm1, maximum, power, sign, sqrt, where

# Shortest time constant of a lag [s]: a shorter one is replaced by it, so that nothing is divided by zero. It is far
# below a sampling interval.
SHORTEST = 1e-4


class Lagged(NamedTuple):
    """The output of a lag over a sampling interval."""

    mean: Scalar  # over the interval [unit of the input]
    end: Scalar  # at its end [unit of the input]


def lagged_ramp(before: Scalar, after: Scalar, output: Scalar, lag: Scalar, time: Scalar) -> Lagged:
    """Response of a first-order lag to a ramp, exact.

    Validity: time constants below `SHORTEST` are replaced by it. Source: solution of lag * y' = u - y with u on a
    straight line; its mean is that of u - lag * y'.
    """
    lag = maximum(lag, SHORTEST)
    behind = (after - before) * (lag / time)
    end = after - behind + (output - before + behind) * exp(-time / lag)
    return Lagged(0.5 * (before + after) - lag / time * (end - output), end)


def share_reached(elapsed: Number) -> Number:
    """Share of a step that the output of a first-order lag has reached.

    Source: solution of lag * y' = u - y with constant u.
    """
    return -expm1(-elapsed)


def gauss_markov_noise(deviation: Scalar, time: Scalar, step: Scalar) -> Scalar:
    """Variance of the process noise of a first-order Gauss-Markov process over a sampling interval.

    Source: P = exp(-2 step / time) P + noise with P = deviation^2.

    Args: deviation: its stationary standard deviation [its unit]; time: its correlation time [s]; step: sampling
    interval [s].

    Returns:
        variance of the noise that keeps the stationary deviation [its unit squared]
    """
    return deviation * deviation * share_reached(2.0 * step / time)


# Smallest share of its rate that a body loses over the time [-]. With less damping, the closed form divides the
# difference of two nearly equal numbers by almost zero; no real bearing loses less in a hundredth of a second.
LEAST_DAMPING = 1e-4


class DampedRotation(NamedTuple):
    """Coefficients of rate and angle increment at the end of the time, for initial rate and torque."""

    kept: Scalar  # rate per initial rate [-]
    path: Scalar  # angle increment per initial rate [s]
    rate_per_torque: Scalar  # [rad/(s*N*m)]
    angle_per_torque: Scalar  # [rad/(N*m)]


def damped_rotation(inertia: Scalar, damping: Scalar, time: Scalar) -> DampedRotation:
    """Transition of a damped rotation under a constant torque, exact.

    Validity: a damping that takes less than `LEAST_DAMPING` of the rate over the time is replaced by one that does.
    Source: solution of inertia * angle'' = torque - damping * angle'. Args: time [s], above zero.
    """
    damping = maximum(damping, LEAST_DAMPING * inertia / time)
    kept = exp(-damping * time / inertia)
    rate_per_torque = (1.0 - kept) / damping
    path = inertia * rate_per_torque
    return DampedRotation(kept, path, rate_per_torque, (time - path) / damping)


def viscous(rate: Number, damping: Scalar) -> Number:
    """Viscous friction torque [N*m].

    Source: Mohtat et al., eq (2), term Beq theta'. Args: damping: torque per rate [N*m*s/rad].
    """
    return damping * rate


def dahl_slope(normalised: Scalar, direction: Scalar, dahl_angle: Scalar, exponent: Scalar = 1.0) -> Scalar:
    """Derivative of the normalised Dahl friction with respect to the angle [1/rad].

    Source: Dahl, AIAA J. 14 (1976) 1675: dT/dtheta = sigma |1 - (T/Tf) sgn|^alpha sgn(1 - (T/Tf) sgn); Raffone, eq (4),
    prints alpha = 1 only and is exact for that value alone. Args: normalised: friction torque over its level, x = T/Tf
    [-], within -1 to 1; dahl_angle: angle over which friction builds up, level over initial stiffness [rad], positive.
    """
    gap = 1.0 - normalised * direction
    return power(maximum(absolute(gap), 1e-300), exponent) * sign(gap) / dahl_angle


def dahl_update(normalised: Scalar, angle_increment: Number, dahl_angle: Scalar) -> Number:
    """Normalised Dahl friction [-] after an angle increment in one direction, exact for exponent 1.

    Source: solution of Dahl's equation with alpha = 1: h <- s + (h - s) exp(-|d theta|/angle), s = sgn(d theta).
    """
    direction = sign(angle_increment)
    return direction + (normalised - direction) * exp(-absolute(angle_increment) / dahl_angle)


def dahl_mean(normalised: Scalar, angle_increment: Scalar, dahl_angle: Scalar) -> Scalar:
    """Mean of the normalised Dahl friction [-] over an angle increment in one direction, exact for exponent 1.

    Source: `dahl_update` integrated over the increment: s + (h - s) (1 - exp(-a)) / a, a = |d theta|/angle.
    """
    direction = sign(angle_increment)
    travel = absolute(angle_increment) / dahl_angle
    short = travel < 1e-6
    lag = where(short, 0.5 * travel, 1.0 - share_reached(travel) / where(short, 1.0, travel))
    return normalised + (direction - normalised) * lag


def dahl_sensitivity_update(
    sensitivity: Scalar, normalised: Scalar, angle_increment: Scalar, dahl_angle: Scalar
) -> Scalar:
    """Derivative [-] of the normalised Dahl friction with respect to ln(dahl_angle), after an angle increment.

    Source: derivative of `dahl_update`: g <- exp(-a) (g + (h - s) a), a = |d theta|/angle. Args: normalised: friction
    torque over its level *before* the increment [-].
    """
    travel = absolute(angle_increment) / dahl_angle
    return exp(-travel) * (sensitivity + (normalised - sign(angle_increment)) * travel)


_CLOSED = 1e-9  # root of a gap that counts as none: friction has reached its level


class BuildUp(NamedTuple):
    """Normalised friction of one law, with its sensitivity to the build-up angle."""

    level: Scalar  # friction torque over its full level, h, within -1 to 1 [-]
    sensitivity: Scalar  # dh / d ln(dahl_angle) [-]


RELAXED = BuildUp(0.0, 0.0)  # State before the first motion: no friction


def finite_build_up(state: BuildUp, angle_increment: Scalar, dahl_angle: Scalar) -> BuildUp:
    """Build-up with exponent 1/2: the level is reached after a finite travel, as with uniformly distributed bristles.

    Source: solution of Dahl's equation (`tierod.physics.friction.dahl_slope`): sqrt(u) falls by a / 2.
    """
    direction, travel, gap, change = _gap(state, angle_increment, dahl_angle)
    root = sqrt(gap)
    remaining = maximum(root - 0.5 * travel, 0.0)
    open_ = root > _CLOSED
    after = remaining * remaining
    slope = where(open_, remaining * (change / where(open_, root, 1.0) + travel), 0.0)
    return _after(state, direction, gap, after, slope)


def exponential_build_up(state: BuildUp, angle_increment: Scalar, dahl_angle: Scalar) -> BuildUp:
    """Build-up with exponent 1, the most common law: u falls as exp(-a).

    Source: `tierod.physics.friction.dahl_update` and its sensitivity.
    """
    return BuildUp(
        dahl_update(state.level, angle_increment, dahl_angle),
        dahl_sensitivity_update(state.sensitivity, state.level, angle_increment, dahl_angle),
    )


def long_build_up(state: BuildUp, angle_increment: Scalar, dahl_angle: Scalar) -> BuildUp:
    """Build-up with exponent 2, with a long tail: u falls as 1 / (1 + a u) and hardly ever reaches zero.

    Source: solution of Dahl's equation (`tierod.physics.friction.dahl_slope`).
    """
    direction, travel, gap, change = _gap(state, angle_increment, dahl_angle)
    shrink = 1.0 / (1.0 + travel * gap)
    slope = (change + gap * gap * travel) * shrink * shrink
    return _after(state, direction, gap, gap * shrink, slope)


def build_ups(
    states: tuple[BuildUp, BuildUp, BuildUp], angle_increment: Scalar, dahl_angle: Scalar
) -> tuple[BuildUp, BuildUp, BuildUp]:
    """The three laws side by side: finite, exponential and long, in this order."""
    finite, exponential, long = states
    return (
        finite_build_up(finite, angle_increment, dahl_angle),
        exponential_build_up(exponential, angle_increment, dahl_angle),
        long_build_up(long, angle_increment, dahl_angle),
    )


def _gap(state: BuildUp, angle_increment: Scalar, dahl_angle: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Direction, travel, gap to the level in that direction, and its derivative with respect to ln(dahl_angle)."""
    direction = sign(angle_increment)
    gap = maximum(1.0 - direction * state.level, 0.0)
    return direction, absolute(angle_increment) / dahl_angle, gap, -direction * state.sensitivity


def _after(state: BuildUp, direction: Scalar, gap: Scalar, gap_after: Scalar, slope: Scalar) -> BuildUp:
    """State after the increment, from the new gap; without motion the direction is zero and nothing changes."""
    moved = absolute(direction) > 0.5
    level = state.level + direction * (gap - gap_after)
    return BuildUp(level, where(moved, -direction * slope, state.sensitivity))
