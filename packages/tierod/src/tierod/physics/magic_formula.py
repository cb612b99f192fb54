"""Pacejka's Magic Formula: pure and combined slip, stiffness and friction over load, pneumatic trail.

Positive slip gives a positive force: a lateral slip to the left turns the car left, a longitudinal slip drives it. The
angle inside the outer sine of the formula is computed once, for force and trail.
"""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import arcsin, arctan, cos, sin, sqrt

REST = 1e-6
"""Normalised slip that is added to the length of the slip vector [-], so that its direction is defined at zero slip."""


class SlipForces(NamedTuple):
    """Forces of one tyre [N], and the angle of the formula that `trail` needs [rad]."""

    longitudinal: Scalar
    lateral: Scalar
    angle: Scalar


def magic_angle(scaled_slip: Scalar, curvature_factor: Scalar) -> Scalar:
    """The angle [rad] that, times the shape factor, is the argument of the sine in the Magic Formula.

    Args:
        scaled_slip: stiffness factor times slip, B x [-]
        curvature_factor: E [-], at most 1

    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed., section 4.3: arctan(B x - E (B x - arctan(B x))).
    """
    return arctan(scaled_slip - curvature_factor * (scaled_slip - arctan(scaled_slip)))


def magic_formula(
    slip: Scalar, stiffness_factor: Scalar, shape_factor: Scalar, peak: Scalar, curvature_factor: Scalar
) -> Scalar:
    """Force or torque of the Magic Formula without offsets, in the unit of the peak.

    Args:
        slip: tangent of the slip angle or slip ratio [-]
        stiffness_factor: B [-]; B C D is the slope at zero
        shape_factor: C [-], about 1.3 for lateral and 1.65 for longitudinal force
        peak: D [N], friction times load
        curvature_factor: E [-], at most 1

    Source: Pacejka, 3rd ed., section 4.3: D sin(C arctan(B x - E (B x - arctan(B x)))).
    """
    return peak * sin(shape_factor * magic_angle(stiffness_factor * slip, curvature_factor))


def scaled_slip_of(share: Scalar, shape_factor: Scalar) -> Scalar:
    """Slip times the stiffness factor, B x [-], at which a force reaches a share of its peak, for curvature factor 0.

    Args:
        share: of the peak [-], below 1
        shape_factor: C [-]

    Source: Pacejka, 3rd ed., section 4.3, with E = 0, solved for the slip.
    """
    angle = arcsin(share) / shape_factor
    return sin(angle) / cos(angle)


def stiffness_per_load(load: Scalar, nominal_load: Scalar, greatest: Scalar, load_of_greatest: Scalar) -> Scalar:
    """Cornering stiffness over load [1/rad]; the stiffness rises degressively with the load to a maximum.

    Args:
        load: vertical load [N], not negative
        nominal_load: Fz0 [N]
        greatest: maximum stiffness over nominal load, pKy1 [1/rad]
        load_of_greatest: load at the maximum stiffness over nominal load, pKy2 [-]

    Source: Pacejka, 3rd ed., section 4.3.2, stiffness without camber: K = pKy1 Fz0 sin(2 arctan(Fz/(pKy2 Fz0))),
    with sin(2 arctan x) = 2 x/(1 + x^2).
    """
    share = load / (load_of_greatest * nominal_load)
    return 2.0 * greatest / load_of_greatest / (1.0 + share * share)


def friction_at_load(load: Scalar, nominal_load: Scalar, friction: Scalar, sensitivity: Scalar) -> Scalar:
    """Peak force over load [-], which falls as the load rises.

    Args:
        load: vertical load [N]
        nominal_load: Fz0 [N]
        friction: at nominal load, pD1 [-]
        sensitivity: change with the load over nominal load, pD2 [-], negative

    Source: Pacejka, 3rd ed., section 4.3.2: mu = pD1 + pD2 (Fz - Fz0)/Fz0.
    """
    return friction + sensitivity * (load / nominal_load - 1.0)


def combined_forces(
    slips: tuple[Scalar, Scalar],
    stiffnesses: tuple[Scalar, Scalar],
    frictions: tuple[Scalar, Scalar],
    load: Scalar,
    shape_factor: Scalar,
    curvature_factor: Scalar,
) -> SlipForces:
    """Forces of a tyre under combined longitudinal and lateral slip.

    Args:
        slips: longitudinal slip, tangent of the slip angle [-]
        stiffnesses: slope of the force at zero slip over load, along and across [1/rad]
        frictions: peak force over load, along and across [-], positive
        load: vertical load [N], not negative; zero is allowed
        shape_factor: C [-], the same in both directions
        curvature_factor: E [-], the same in both directions

    Each slip is normalised by the one at which the linear tyre would reach its peak. The length of the normalised slip
    gives the share of the peak, its direction the two components. With pure slip this is `magic_formula`.
    Source: similarity of Pacejka (3rd ed., section 4.2) and normalisation of Radt in the form of Sharp and Bettella,
    Vehicle System Dynamics 39 (2003) 27, without their transformation of the slips.
    """
    along = stiffnesses[0] * slips[0] / frictions[0]
    across = stiffnesses[1] * slips[1] / frictions[1]
    length = sqrt(along * along + across * across + REST * REST)
    angle = magic_angle(length / shape_factor, curvature_factor)
    secant = load * sin(shape_factor * angle) / length
    return SlipForces(stiffnesses[0] * slips[0] * secant, stiffnesses[1] * slips[1] * secant, angle)


def trail(load: Scalar, nominal_load: Scalar, nominal_trail: Scalar, angle: Scalar, shape_factor: Scalar) -> Scalar:
    """Pneumatic trail [m], which grows with the load and vanishes as the tyre slips.

    Args:
        load: vertical load [N]
        nominal_load: Fz0 [N]
        nominal_trail: at nominal load without slip [m]
        angle: from `magic_angle`, of the combined slip [rad]
        shape_factor: Ct [-], 1.0 to 1.2; above one the trail turns a little negative where the tyre slides

    Source: Pacejka, 3rd ed., section 4.3.2: t = Dt cos(Ct arctan(Bt a - Et (Bt a - arctan(Bt a)))), Dt growing with
    the load, the equivalent slip for combined slip; here Bt and Et are those of the lateral force.
    """
    return nominal_trail * load / nominal_load * cos(shape_factor * angle)
