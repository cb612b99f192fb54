"""Lateral force and aligning torque of a tyre or an axle.

Slip, force and torque are positive in a left turn: a positive slip gives a force to the left, and an aligning torque
about the kingpin that opposes positive steer. Stiffness and load are both those of one wheel, or both of one axle.
The lateral slip is the tangent of the slip angle; below 0.1 rad the angle itself is accurate enough.
"""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, absolute, maximum, sign, sqrt


def linear_lateral_force(slip_angle: Number, cornering_stiffness: Scalar) -> Number:
    """Lateral force [N] in proportion to the slip angle.

    Args:
        slip_angle: [rad]
        cornering_stiffness: [N/rad]

    Validity: up to about 0.4 times the adhesion limit.
    """
    return cornering_stiffness * slip_angle


def sliding_slip(cornering_stiffness: Scalar, adhesion: Scalar, load: Scalar) -> Scalar:
    """Tangent of the slip angle [-] at which the whole contact patch of the brush model slides.

    Args:
        cornering_stiffness: [N/rad]
        adhesion: friction coefficient of tyre and road [-]
        load: vertical load [N]

    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed., section 3.2.1: tan(alpha_sl) = 3 mu Fz / C.
    """
    return 3.0 * adhesion * load / cornering_stiffness


def brush_lateral_force(lateral_slip: Scalar, cornering_stiffness: Scalar, adhesion: Scalar, load: Scalar) -> Scalar:
    """Lateral force [N] of the brush model with parabolic pressure, the same as Fiala's.

    Args:
        lateral_slip: tangent of the slip angle [-]
        cornering_stiffness: [N/rad]
        adhesion: friction coefficient of tyre and road [-]
        load: vertical load [N]

    Validity: pure side slip, rigid carcass, one friction coefficient.
    Source: Fiala (1954); Pacejka, 3rd ed., section 3.2.1: F = mu Fz (1 - (1 - x)^3), x = tan(alpha)/tan(alpha_sl), and
    mu Fz beyond x = 1.
    """
    share = lateral_slip / sliding_slip(cornering_stiffness, adhesion, load)
    sticking = maximum(1.0 - absolute(share), 0.0)
    return adhesion * load * sign(share) * (1.0 - sticking * sticking * sticking)


def saturating_lateral_force(lateral_slip: Scalar, cornering_stiffness: Scalar, greatest: Scalar) -> Scalar:
    """Lateral force [N] that grows with the slip and saturates, smooth and without a transcendental function.

    Args:
        lateral_slip: tangent of the slip angle [-]
        cornering_stiffness: [N/rad]
        greatest: force at saturation [N], positive

    Validity: up to the peak; a real tyre's force then falls. The curve lies between brush model and Magic Formula.
    Source: the algebraic sigmoid x / sqrt(1 + x^2), scaled by the slope at zero and the level.
    """
    share = cornering_stiffness * lateral_slip / greatest
    return cornering_stiffness * lateral_slip / sqrt(1.0 + share * share)


def brush_aligning_torque(
    lateral_slip: Scalar, cornering_stiffness: Scalar, adhesion: Scalar, load: Scalar, contact_half_length: Scalar
) -> Scalar:
    """Aligning torque [N*m] of the brush model about the contact centre, opposing positive steer.

    Args:
        lateral_slip: tangent of the slip angle [-]
        cornering_stiffness: [N/rad]
        adhesion: friction coefficient of tyre and road [-]
        load: vertical load [N]
        contact_half_length: half of the contact length, a [m]

    Source: Pacejka, 3rd ed., section 3.2.1: M = mu Fz a x (1 - |x|)^3, with reversed sign, since M here opposes steer.
    """
    share = lateral_slip / sliding_slip(cornering_stiffness, adhesion, load)
    sticking = maximum(1.0 - absolute(share), 0.0)
    return adhesion * load * contact_half_length * share * sticking * sticking * sticking


def relaxation_rate(deflection: Scalar, lateral_slip_speed: Scalar, speed: Scalar, relaxation_length: Scalar) -> Scalar:
    """Rate [m/s] of the lateral deflection of a rolling tyre; deflection over relaxation length is the effective slip.

    Args:
        deflection: lateral deflection [m]
        lateral_slip_speed: lateral speed of the contact patch across the wheel plane [m/s]; over the forward speed it
            is the tangent of the slip angle
        speed: forward speed [m/s], not negative; zero is allowed
        relaxation_length: distance over which the force builds up [m]

    Source: Pacejka, 3rd ed., eq (7.7): du/dt + |V| u / sigma = Vsy.
    """
    return lateral_slip_speed - absolute(speed) / relaxation_length * deflection


def bounded_relaxation_rate(
    deflection: Scalar, slip_speed: Scalar, speed: Scalar, relaxation_length: Scalar, shortest_time: Scalar
) -> Scalar:
    """Rate [m/s] of the deflection of a rolling tyre, bounded so that a fixed-step integration is stable at any speed.

    Args:
        deflection: of the tyre [m]
        slip_speed: of the contact patch in the direction of the deflection [m/s]
        speed: forward speed, for example from `relaxation_speed`, not negative [m/s]
        relaxation_length: distance over which the force builds up [m]
        shortest_time: added to the time constant sigma/V, which therefore never falls below it [s]

    Source: `relaxation_rate` with a lag of the tread in series; the steady-state deflection is the same.
    """
    rate = relaxation_rate(deflection, slip_speed, speed, relaxation_length)
    return rate / (1.0 + shortest_time / relaxation_length * speed)


def relaxation_speed(speed_squared: Scalar, slip_speed_squared: Scalar, greatest_slip: Scalar) -> Scalar:
    """Equivalent speed [m/s] for the relaxation of a deflection, which keeps the effective slip below a maximum.

    Args:
        speed_squared: square of the wheel's forward speed [m**2/s**2]
        slip_speed_squared: square of the speed of the contact patch over the ground [m**2/s**2]
        greatest_slip: effective slip of a patch that slides over the ground without rolling [-]

    A fourth-power norm, (V^4 + (Vs/s)^4)^(1/4): within 2 % of the wheel's own speed below half of the maximum slip, and
    within 0.04 % below a fifth of it. Without it the deflection of a locked tyre that is dragged grows without bound.
    """
    sliding_squared = slip_speed_squared / (greatest_slip * greatest_slip)
    return sqrt(sqrt(speed_squared * speed_squared + sliding_squared * sliding_squared))


def twist_rate(
    twist: Scalar, turning: Scalar, speed: Scalar, greatest_twist: Scalar, relaxation_length: Scalar
) -> Scalar:
    """Rate [rad/s] of the twist of a contact patch about its vertical axis.

    Args:
        twist: of the patch [rad]; over the largest twist it is the scrub torque over the parking torque
        turning: rate of the wheel about the vertical axis relative to the ground: steer plus yaw [rad/s]
        speed: forward speed of the wheel [m/s]
        greatest_twist: twist at which the whole patch slides [rad]
        relaxation_length: rolled distance over which a twist decays [m]

    At rest Dahl's friction (exponent 1); rolling, a first-order lag over distance as in Pacejka, 3rd ed., eq (7.7).
    """
    return turning - (absolute(speed) / relaxation_length + absolute(turning) / greatest_twist) * twist


def turn_slip(turning: Scalar, speed: Scalar) -> Scalar:
    """Turn slip [1/m] of a rolling wheel: its rotation about the vertical axis per distance.

    Args:
        turning: rate of the wheel about the vertical axis relative to the ground: steer plus yaw [rad/s]
        speed: forward speed of the wheel [m/s], above walking pace

    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 2, without camber and with the sign of the turn.
    `twist_rate` settles at the turn slip times its relaxation length.
    """
    return turning / speed


def turn_slip_stiffness(longitudinal_stiffness: Scalar, half_width: Scalar) -> Scalar:
    """Torque [N*m] per turn slip [1/m] of a brush tyre, from the width of its contact patch.

    Args:
        longitudinal_stiffness: force per longitudinal slip [N]; if it is given over load, so is the result [m**2]
        half_width: half of the width of the contact patch [m]

    A bristle at a lateral distance from the centre of the patch has a longitudinal slip of that distance times the turn
    slip; over the width, the mean of the distance squared is a third of the half width squared.
    Validity: small turn slip; without the lateral forces that a long patch adds.
    """
    return longitudinal_stiffness * half_width * half_width / 3.0


def parking_torque(load: Scalar, adhesion: Scalar, pressure: Scalar) -> Scalar:
    """Torque [N*m] about the kingpin that turns one standing wheel on the ground.

    Args:
        load: vertical load of the wheel [N]
        adhesion: friction coefficient of tyre and road [-]
        pressure: inflation pressure [Pa]

    Validity: standing wheel, fully twisted; falls within a few contact lengths of rolling.
    Source: Gough's formula, as in Sharp and Granger, Proc. IMechE D 217 (2003) 87: M = (mu W / 3) sqrt(W / p).
    """
    return adhesion * load / 3.0 * sqrt(load / pressure)
