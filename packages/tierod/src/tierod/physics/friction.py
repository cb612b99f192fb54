"""Dry friction: its laws, and its build-up along the path."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, absolute, exp, maximum, power, sign, sqrt, tanh, where
from tierod.physics.lag import share_reached


def coulomb(rate: Scalar, level: Scalar) -> Scalar:
    """Dry friction torque [N*m] that depends on the direction of motion only.

    Args:
        rate: angular rate [rad/s]
        level: friction torque while moving [N*m], not negative

    Validity: motion beyond the pre-sliding range; zero at standstill, where the true torque is undetermined.
    Source: Mohtat et al., eq (2), term Tf sgn(theta').
    """
    return level * sign(rate)


def smooth_coulomb(rate: Scalar, level: Scalar, width: Scalar) -> Scalar:
    """Dry friction torque [N*m] smoothed by a hyperbolic tangent, so that it has a derivative.

    Args:
        rate: angular rate [rad/s]
        level: friction torque while moving [N*m]
        width: rate at which 76 % of the level is reached [rad/s]; a smaller one lets a filter chatter, with a larger
            one the model creeps at low rates

    Validity: rates well above the width; creeps at standstill.
    """
    return level * tanh(rate / width)


def smooth_sign_slope(rate: Scalar, width: Scalar) -> Scalar:
    """Derivative [s/rad] of the sign function smoothed by a hyperbolic tangent: twice a Dirac delta of finite width.

    Args:
        rate: angular rate [rad/s]
        width: rate at which 76 % of the sign is reached [rad/s]

    Source: d tanh(x / w) / dx; its integral over all rates is 2, as that of d sgn(x) / dx = 2 delta(x) in eq (19) of
    Mohtat et al., printed without the factor.
    """
    level = tanh(rate / width)
    return (1.0 - level * level) / width


def viscous(rate: Number, damping: Scalar) -> Number:
    """Viscous friction torque [N*m].

    Args:
        rate: angular rate [rad/s]
        damping: torque per rate [N*m*s/rad]

    Source: Mohtat et al., eq (2), term Beq theta'.
    """
    return damping * rate


def stribeck_level(
    rate: Scalar, static_level: Scalar, sliding_level: Scalar, stribeck_rate: Scalar, shape: Scalar = 2.0
) -> Scalar:
    """Level of dry friction [N*m], falling from the static to the sliding one as the rate grows.

    Args:
        rate: angular rate [rad/s]
        static_level: level at standstill [N*m]
        sliding_level: level far above the Stribeck rate [N*m]
        stribeck_rate: rate at which the excess has fallen to 1/e [rad/s], positive
        shape: exponent of the curve [-], 0.5 to 2

    Source: Bo and Pavelescu, Wear 82 (1982) 277, as used by Canudas de Wit et al. (1995), eq (4), with exponent 2.
    """
    excess = power(maximum(absolute(rate) / stribeck_rate, 1e-30), shape)
    return sliding_level + (static_level - sliding_level) * exp(-excess)


def dahl_slope(normalised: Scalar, direction: Scalar, dahl_angle: Scalar, exponent: Scalar = 1.0) -> Scalar:
    """Derivative of the normalised Dahl friction with respect to the angle [1/rad].

    Args:
        normalised: friction torque over its level, x = T/Tf [-], within -1 to 1
        direction: sign of the rate [-]
        dahl_angle: angle over which friction builds up, level over initial stiffness [rad], positive
        exponent: alpha, shape of the build-up [-]; 1 exponential, below 1 steeper, above 1 longer tail

    Source: Dahl, AIAA J. 14 (1976) 1675: dT/dtheta = sigma |1 - (T/Tf) sgn|^alpha sgn(1 - (T/Tf) sgn);
    Raffone, eq (4), prints alpha = 1 only and is exact for that value alone.
    """
    gap = 1.0 - normalised * direction
    return power(maximum(absolute(gap), 1e-300), exponent) * sign(gap) / dahl_angle


def dahl_update(normalised: Scalar, angle_increment: Number, dahl_angle: Scalar) -> Number:
    """Normalised Dahl friction [-] after an angle increment in one direction, exact for exponent 1.

    Args:
        normalised: friction torque over its level before the increment [-]
        angle_increment: [rad], without reversal inside
        dahl_angle: level over initial stiffness [rad], positive

    Source: solution of Dahl's equation with alpha = 1: h <- s + (h - s) exp(-|d theta|/angle), s = sgn(d theta).
    """
    direction = sign(angle_increment)
    return direction + (normalised - direction) * exp(-absolute(angle_increment) / dahl_angle)


def dahl_mean(normalised: Scalar, angle_increment: Scalar, dahl_angle: Scalar) -> Scalar:
    """Mean of the normalised Dahl friction [-] over an angle increment in one direction, exact for exponent 1.

    Args:
        normalised: friction torque over its level before the increment [-]
        angle_increment: [rad], without reversal inside
        dahl_angle: level over initial stiffness [rad], positive

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

    Args:
        sensitivity: dh / d ln(dahl_angle) before the increment [-]
        normalised: friction torque over its level *before* the increment [-]
        angle_increment: [rad], without reversal inside
        dahl_angle: level over initial stiffness [rad], positive

    Source: derivative of `dahl_update`: g <- exp(-a) (g + (h - s) a), a = |d theta|/angle.
    """
    travel = absolute(angle_increment) / dahl_angle
    return exp(-travel) * (sensitivity + (normalised - sign(angle_increment)) * travel)


def dahl_power_update(normalised: Scalar, angle_increment: Scalar, dahl_angle: Scalar, exponent: Scalar) -> Scalar:
    """Normalised Dahl friction [-] after an angle increment in one direction, exact for any exponent from 0 to 5.

    Args:
        normalised: friction torque over its level before the increment [-]
        angle_increment: [rad], without reversal inside
        dahl_angle: level over initial stiffness [rad], positive
        exponent: alpha of `dahl_slope` [-]

    The gap u = |1 - x sgn| obeys du/da = -u^alpha, so u^(1-alpha) falls linearly with the travel a; exponents within
    1e-6 of one use the exponential. Below one the level is reached after a finite travel.
    """
    direction = sign(angle_increment)
    travel = absolute(angle_increment) / dahl_angle
    # Both branches of `where` are evaluated: neither a gap of zero nor an exponent of one may divide by zero.
    gap = maximum(absolute(1.0 - normalised * direction), 1e-60)
    order = 1.0 - exponent
    exponential = absolute(order) < 1e-6
    safe_order = where(exponential, 1.0, order)
    remaining = maximum(1.0 - safe_order * travel * power(gap, -safe_order), 0.0)
    share = where(exponential, exp(-travel), power(remaining, 1.0 / safe_order))
    return direction + (normalised - direction) * share


def lugre_bristle_rate(deflection: Scalar, rate: Scalar, stiffness: Scalar, level: Scalar) -> Scalar:
    """Rate of the mean bristle deflection [rad/s] of the LuGre model.

    Args:
        deflection: mean bristle deflection [rad]
        rate: angular rate [rad/s]
        stiffness: bristle stiffness, sigma_0 [N*m/rad]
        level: steady friction torque at this rate [N*m], for example from `stribeck_level`

    Source: Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE TAC 40 (1995) 419, eq (2).
    """
    return rate - absolute(rate) * stiffness * deflection / level


def lugre_torque(
    deflection: Scalar, bristle_rate: Scalar, rate: Scalar, stiffness: Scalar, micro_damping: Scalar, damping: Scalar
) -> Scalar:
    """Friction torque [N*m] of the LuGre model.

    Args:
        deflection: mean bristle deflection [rad]
        bristle_rate: its rate, from `lugre_bristle_rate` [rad/s]
        rate: angular rate [rad/s]
        stiffness: bristle stiffness, sigma_0 [N*m/rad]
        micro_damping: damping of the bristles, sigma_1 [N*m*s/rad]
        damping: viscous damping, sigma_2 [N*m*s/rad]

    Source: Canudas de Wit et al. (1995), eq (3).
    """
    return stiffness * deflection + micro_damping * bristle_rate + damping * rate


_CLOSED = 1e-9  # root of a gap that counts as none: friction has reached its level


class BuildUp(NamedTuple):
    """Normalised friction of one law, with its sensitivity to the build-up angle."""

    level: Scalar  # friction torque over its full level, h, within -1 to 1 [-]
    sensitivity: Scalar  # dh / d ln(dahl_angle) [-]


RELAXED = BuildUp(0.0, 0.0)  # State before the first motion: no friction


def finite_build_up(state: BuildUp, angle_increment: Scalar, dahl_angle: Scalar) -> BuildUp:
    """Build-up with exponent 1/2: the level is reached after a finite travel, as with uniformly distributed bristles.

    Args:
        state: before the increment
        angle_increment: [rad], without reversal inside
        dahl_angle: level over initial stiffness [rad], positive

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

    Args:
        state: before the increment
        angle_increment: [rad], without reversal inside
        dahl_angle: level over initial stiffness [rad], positive

    Source: `tierod.physics.friction.dahl_update` and its sensitivity.
    """
    return BuildUp(
        dahl_update(state.level, angle_increment, dahl_angle),
        dahl_sensitivity_update(state.sensitivity, state.level, angle_increment, dahl_angle),
    )


def long_build_up(state: BuildUp, angle_increment: Scalar, dahl_angle: Scalar) -> BuildUp:
    """Build-up with exponent 2, with a long tail: u falls as 1 / (1 + a u) and hardly ever reaches zero.

    Args:
        state: before the increment
        angle_increment: [rad], without reversal inside
        dahl_angle: level over initial stiffness [rad], positive

    Source: solution of Dahl's equation (`tierod.physics.friction.dahl_slope`).
    """
    direction, travel, gap, change = _gap(state, angle_increment, dahl_angle)
    shrink = 1.0 / (1.0 + travel * gap)
    slope = (change + gap * gap * travel) * shrink * shrink
    return _after(state, direction, gap, gap * shrink, slope)


def build_ups(
    states: tuple[BuildUp, BuildUp, BuildUp], angle_increment: Scalar, dahl_angle: Scalar
) -> tuple[BuildUp, BuildUp, BuildUp]:
    """The three laws side by side: finite, exponential and long, in this order.

    Args:
        states: before the increment
        angle_increment: [rad], without reversal inside
        dahl_angle: level over initial stiffness [rad], positive
    """
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
