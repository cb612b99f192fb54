"""Transforms of three-phase quantities: phases to stator axes (Clarke), stator axes to rotor axes (Park), and back.

All are amplitude-invariant: a phase amplitude of 1 A is a vector of length 1 A, and power is 3/2 of the product.
The angle of a Park transform is *electrical*: pole pairs times the mechanical angle of the rotor."""

from __future__ import annotations

import math
from typing import Generic, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, cos, floor, sin


def wrapped(angle: Scalar) -> Scalar:
    """Angle wrapped to half a turn on either side of zero [rad].

    Args:
        angle: any number of turns [rad]

    Returns:
        from -pi (included) to pi (excluded) [rad]
    """
    return angle - 2.0 * math.pi * floor(angle / (2.0 * math.pi) + 0.5)


_SQRT_3 = 3.0**0.5


class PhaseValues(NamedTuple, Generic[Number]):
    """One number per phase."""

    a: Number
    b: Number
    c: Number


class StatorVector(NamedTuple, Generic[Number]):
    """A vector in the stator's axes."""

    alpha: Number
    beta: Number


class RotorVector(NamedTuple, Generic[Number]):
    """A vector in the rotor's axes: d along the magnets' flux, q across."""

    d: Number
    q: Number


class Direction(NamedTuple, Generic[Number]):
    """Cosine and sine of an electrical angle, computed once for many vectors."""

    cosine: Number
    sine: Number


def electrical_angle(mechanical_angle: Scalar, pole_pairs: Scalar) -> Scalar:
    """Electrical angle [rad] of a rotor.

    Args:
        mechanical_angle: of the shaft [rad]
        pole_pairs: z_p [-]
    """
    return pole_pairs * mechanical_angle


def direction(electrical_angle: Number) -> Direction[Number]:
    """Direction of an electrical angle [rad]."""
    return Direction(cos(electrical_angle), sin(electrical_angle))


def turned(before: Direction, electrical_increment: Scalar) -> Direction:
    """A direction turned by a small electrical angle [rad], by polynomials instead of sine and cosine.

    Validity: increments below 0.3 rad, where the error stays below 1e-6 (Taylor polynomials of order 4 and 5); the
    length drifts by as much, so recompute the direction with `direction` from time to time.
    """
    square = electrical_increment * electrical_increment
    cosine = 1.0 + square * (square * (1.0 / 24.0) - 0.5)
    sine = electrical_increment * (1.0 + square * (square * (1.0 / 120.0) - 1.0 / 6.0))
    return Direction(before.cosine * cosine - before.sine * sine, before.sine * cosine + before.cosine * sine)


def clarke(phases: PhaseValues[Number]) -> StatorVector[Number]:
    """Phase values in the stator's axes, amplitude-invariant; the zero sequence drops out.

    Args:
        phases: currents [A] or voltages [V]

    Source: Reinelt et al., eqs (5) to (7), to which this is equal where the phases add up to zero.
    """
    return StatorVector((2.0 * phases.a - phases.b - phases.c) / 3.0, (phases.b - phases.c) / _SQRT_3)


def inverse_clarke(vector: StatorVector[Number]) -> PhaseValues[Number]:
    """Phase values, adding up to zero, of a vector in the stator's axes.

    Source: Reinelt et al., eqs (5) to (7), solved for the phases.
    """
    half, side = 0.5 * vector.alpha, 0.5 * _SQRT_3 * vector.beta
    return PhaseValues(vector.alpha, side - half, -half - side)


def park(vector: StatorVector[Number], rotor: Direction[Number]) -> RotorVector[Number]:
    """A vector in the rotor's axes.

    Source: Reinelt et al., eqs (8) and (9), where theta is the electrical angle.
    """
    return RotorVector(
        vector.alpha * rotor.cosine + vector.beta * rotor.sine,
        vector.beta * rotor.cosine - vector.alpha * rotor.sine,
    )


def inverse_park(vector: RotorVector[Number], rotor: Direction[Number]) -> StatorVector[Number]:
    """A vector in the stator's axes.

    Source: Reinelt et al., eqs (10) and (11), where theta is the electrical angle.
    """
    return StatorVector(
        vector.d * rotor.cosine - vector.q * rotor.sine,
        vector.d * rotor.sine + vector.q * rotor.cosine,
    )
