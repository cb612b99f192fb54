"""Tyres: linear, saturating, magic formula, turn slip.

Arguments, unless a function says otherwise: angle: from `magic_angle`, of the combined slip [rad]; cornering_stiffness
[N/rad]; curvature_factor: E [-], at most 1; greatest: force at saturation [N], positive; greatest_twist: twist at which
the whole patch slides [rad]; half_width: half of the width of the contact patch [m]; if it is given over load, so is
the result [m**2]; lateral_slip: tangent of the slip angle [-]; load: vertical load [N]; longitudinal_stiffness: force
per longitudinal slip [N]; nominal_load: Fz0 [N]; nominal_trail: at nominal load without slip [m]; peak: D [N], friction
times load; relaxation_length: rolled distance over which a twist decays [m]; scaled_slip: stiffness factor times slip,
B x [-]; shape_factor: C [-], about 1.3 for lateral and 1.65 for longitudinal force; share: of the peak [-], below 1;
slip: tangent of the slip angle or slip ratio [-]; slip_angle [rad]; speed: forward speed of the wheel [m/s];
stiffness_factor: B [-]; B C D is the slope at zero; turning: rate of the wheel about the vertical axis relative to the
ground: steer plus yaw [rad/s]; twist: of the patch [rad]; over the largest twist it is the scrub torque over the
parking torque.
"""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, absolute, arcsin, arctan, cos, sin, sqrt


def linear_lateral_force(slip_angle: Number, cornering_stiffness: Scalar) -> Number:
    """Lateral force [N] in proportion to the slip angle. Validity: up to about 0.4 times the adhesion limit."""
    return cornering_stiffness * slip_angle


def saturating_lateral_force(lateral_slip: Scalar, cornering_stiffness: Scalar, greatest: Scalar) -> Scalar:
    """Lateral force [N] that grows with the slip and saturates, smooth and without a transcendental function.

    Validity: up to the peak; a real tyre's force then falls. The curve lies between brush model and Magic Formula.
    Source: the algebraic sigmoid x / sqrt(1 + x^2), scaled by the slope at zero and the level.
    """
    share = cornering_stiffness * lateral_slip / greatest
    return cornering_stiffness * lateral_slip / sqrt(1.0 + share * share)


def twist_rate(
    twist: Scalar, turning: Scalar, speed: Scalar, greatest_twist: Scalar, relaxation_length: Scalar
) -> Scalar:
    """Rate [rad/s] of the twist of a contact patch about its vertical axis.

    At rest Dahl's friction (exponent 1); rolling, a first-order lag over distance as in Pacejka, 3rd ed., eq (7.7).
    """
    return turning - (absolute(speed) / relaxation_length + absolute(turning) / greatest_twist) * twist


def turn_slip(turning: Scalar, speed: Scalar) -> Scalar:
    """Turn slip [1/m] of a rolling wheel: its rotation about the vertical axis per distance.

    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 2, without camber and with the sign of the turn.
    `twist_rate` settles at the turn slip times its relaxation length. Args: speed: forward speed of the wheel [m/s],
    above walking pace.
    """
    return turning / speed


def turn_slip_stiffness(longitudinal_stiffness: Scalar, half_width: Scalar) -> Scalar:
    """Torque [N*m] per turn slip [1/m] of a brush tyre, from the width of its contact patch.

    A bristle at a lateral distance from the centre of the patch has a longitudinal slip of that distance times the turn
    slip; over the width, the mean of the distance squared is a third of the half width squared.
    Validity: small turn slip; without the lateral forces that a long patch adds.
    """
    return longitudinal_stiffness * half_width * half_width / 3.0


def magic_angle(scaled_slip: Scalar, curvature_factor: Scalar) -> Scalar:
    """The angle [rad] that, times the shape factor, is the argument of the sine in the Magic Formula.

    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed., section 4.3: arctan(B x - E (B x - arctan(B x))).
    """
    return arctan(scaled_slip - curvature_factor * (scaled_slip - arctan(scaled_slip)))


def magic_formula(
    slip: Scalar, stiffness_factor: Scalar, shape_factor: Scalar, peak: Scalar, curvature_factor: Scalar
) -> Scalar:
    """Force or torque of the Magic Formula without offsets, in the unit of the peak.

    Source: Pacejka, 3rd ed., section 4.3: D sin(C arctan(B x - E (B x - arctan(B x)))).
    """
    return peak * sin(shape_factor * magic_angle(stiffness_factor * slip, curvature_factor))


def scaled_slip_of(share: Scalar, shape_factor: Scalar) -> Scalar:
    """Slip times the stiffness factor, B x [-], at which a force reaches a share of its peak, for curvature factor 0.

    Source: Pacejka, 3rd ed., section 4.3, with E = 0, solved for the slip. Args: shape_factor: C [-].
    """
    angle = arcsin(share) / shape_factor
    return sin(angle) / cos(angle)


def trail(load: Scalar, nominal_load: Scalar, nominal_trail: Scalar, angle: Scalar, shape_factor: Scalar) -> Scalar:
    """Pneumatic trail [m], which grows with the load and vanishes as the tyre slips.

    Source: Pacejka, 3rd ed., section 4.3.2: t = Dt cos(Ct arctan(Bt a - Et (Bt a - arctan(Bt a)))), Dt growing with the
    load, the equivalent slip for combined slip; here Bt and Et are those of the lateral force. Args: shape_factor: Ct
    [-], 1.0 to 1.2; above one the trail turns a little negative where the tyre slides.
    """
    return nominal_trail * load / nominal_load * cos(shape_factor * angle)
