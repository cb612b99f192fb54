"""Build-up of dry friction after a reversal, with its derivative with respect to the logarithm of the build-up angle.

Three members of Dahl's family in closed form, for estimators of a steering whose law of friction is unknown. The gap
u = 1 - h sgn(d theta) to the full level obeys du/da = -u^alpha over the travel a = |d theta| / angle.
"""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, maximum, sign, sqrt, where
from tierod.physics.friction import dahl_sensitivity_update, dahl_update

_CLOSED = 1e-9  # root of a gap that counts as none: friction has reached its level


class BuildUp(NamedTuple):
    """Normalised friction of one law, with its sensitivity to the build-up angle.

    Args:
        level: friction torque over its full level, h, within -1 to 1 [-]
        sensitivity: dh / d ln(dahl_angle) [-]
    """

    level: Scalar
    sensitivity: Scalar


RELAXED = BuildUp(0.0, 0.0)
"""State before the first motion: no friction."""


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
