"""Formulas of the virtual vehicle: steering, motor, active return and path following."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, exp, maximum, power, sign, sqrt, tanh, where
from tierod.physics.motor import Direction, RotorVector, StatorVector, Vector, inverse_park, park


def stribeck_level(
    rate: Scalar, static_level: Scalar, sliding_level: Scalar, stribeck_rate: Scalar, shape: Scalar = 2.0
) -> Scalar:
    """Level of dry friction [N*m], falling from the static to the sliding one as the rate grows.

    Source: Bo and Pavelescu, Wear 82 (1982) 277, as used by Canudas de Wit et al. (1995), eq (4), with exponent 2.

    Args: rate: angular rate [rad/s]; static_level: level at standstill [N*m]; sliding_level: level far above the
    Stribeck rate [N*m]; stribeck_rate: rate at which the excess has fallen to 1/e [rad/s], positive; shape: exponent of
    the curve [-], 0.5 to 2.
    """
    excess = power(maximum(absolute(rate) / stribeck_rate, 1e-30), shape)
    return sliding_level + (static_level - sliding_level) * exp(-excess)


def dahl_power_update(normalised: Scalar, angle_increment: Scalar, dahl_angle: Scalar, exponent: Scalar) -> Scalar:
    """Normalised Dahl friction [-] after an angle increment in one direction, exact for any exponent from 0 to 5.

    The gap u = |1 - x sgn| obeys du/da = -u^alpha, so u^(1-alpha) falls linearly with the travel a; exponents within
    1e-6 of one use the exponential. Below one the level is reached after a finite travel.

    Args: normalised: friction torque over its level before the increment [-]; angle_increment [rad], without reversal
    inside; dahl_angle: level over initial stiffness [rad], positive; exponent: alpha of `dahl_slope` [-].
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

    Source: Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE TAC 40 (1995) 419, eq (2).

    Args: deflection: mean bristle deflection [rad]; rate: angular rate [rad/s]; stiffness: bristle stiffness, sigma_0
    [N*m/rad]; level: steady friction torque at this rate [N*m], for example from `stribeck_level`.
    """
    return rate - absolute(rate) * stiffness * deflection / level


def lugre_torque(
    deflection: Scalar, bristle_rate: Scalar, rate: Scalar, stiffness: Scalar, micro_damping: Scalar, damping: Scalar
) -> Scalar:
    """Friction torque [N*m] of the LuGre model.

    Source: Canudas de Wit et al. (1995), eq (3).

    Args: deflection: mean bristle deflection [rad]; bristle_rate: its rate, from `lugre_bristle_rate` [rad/s]; rate:
    angular rate [rad/s]; stiffness: bristle stiffness, sigma_0 [N*m/rad]; micro_damping: damping of the bristles,
    sigma_1 [N*m*s/rad]; damping: viscous damping, sigma_2 [N*m*s/rad].
    """
    return stiffness * deflection + micro_damping * bristle_rate + damping * rate


def lash_torque(twist: Scalar, twist_rate: Scalar, stiffness: Scalar, damping: Scalar, play: Scalar) -> Scalar:
    """Torque [N*m] that meshing gears transmit, in the direction of their twist; a force if twist is a distance [m].

    Flanks push and never pull: while they separate, damping ends the contact before the elastic deflection is gone.
    Source: Nordin and Gutman, Automatica 38 (2002) 1633, dead-zone model with damping; the condition on the sign is the
    release condition of their physical model.

    Args: twist: of the driving against the driven side [rad], zero in the middle of the play; twist_rate: its rate
    [rad/s]; stiffness: of the flanks in contact [N*m/rad]; damping: of the flanks in contact [N*m*s/rad]; play: total
    backlash from flank to flank [rad]; zero is a meshing without backlash, linear in both directions.
    """
    depth = absolute(twist) - 0.5 * play
    direction = sign(twist)
    push = maximum(stiffness * depth + damping * direction * twist_rate, 0.0)
    loose = where(depth > 0.0, direction * push, 0.0)
    return where(play > 0.0, loose, stiffness * twist + damping * twist_rate)


def variable_ratio(steering_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar) -> Scalar:
    """Ratio [-] of a rack that becomes more direct away from the centre.

    Args: steering_wheel_angle [rad]; centre_ratio: ratio at the centre [-]; growth: relative growth with the squared
    angle [1/rad**2]; zero is a constant ratio.
    """
    return centre_ratio * (1.0 + growth * steering_wheel_angle * steering_wheel_angle)


def ackermann_angle(mean_angle: Scalar, gain: Scalar) -> Scalar:
    """Steer [rad] of the left front wheel; the right one has the gain with the other sign.

    Validity: the second order of cot(right) - cot(left) = track / wheelbase; the difference of both wheels is 5 % too
    large at 0.35 rad and 11 % at 0.5 rad.
    Source: Rajamani, Vehicle Dynamics and Control (2012), section 2.2:
    the difference of both wheels is steer^2 track / wheelbase.

    Args: mean_angle: mean steer of both front wheels [rad], positive left; gain: half the difference of both wheels per
    squared steer [1/rad]; track / (2 wheelbase) lets all wheels roll about one centre (full Ackermann), zero keeps the
    wheels parallel.
    """
    return mean_angle + gain * mean_angle * mean_angle


def ackermann_slope(mean_angle: Scalar, gain: Scalar) -> Scalar:
    """Derivative of `ackermann_angle` with respect to the mean steer [-].

    Args: mean_angle: mean steer of both front wheels [rad]; gain: as in `ackermann_angle` [1/rad].
    """
    return 1.0 + 2.0 * gain * mean_angle


def limited_voltage(wanted: Vector, longest: Scalar) -> Vector:
    """Voltage vector limited in length, with its direction kept.

    Args: wanted: StatorVector or RotorVector [V]; longest [V], positive.
    """
    first, second = wanted
    # The maximum under the root makes the factor 1 for short vectors, and defined for the zero vector.
    share = longest / sqrt(maximum(first * first + second * second, longest * longest))
    return type(wanted)(share * first, share * second)


def torque_of_flux(linkage: StatorVector, current: StatorVector, pole_pairs: Scalar) -> Scalar:
    """Torque [N*m] on the shaft from flux linkage and current, both in the same axes.

    Source: 3/2 z_p (psi x i), equal to `electromagnetic_torque`.

    Args: linkage: of the stator [V*s]; current [A]; pole_pairs: z_p [-].
    """
    return 1.5 * pole_pairs * (linkage.alpha * current.beta - linkage.beta * current.alpha)


def current_of_flux(
    linkage: StatorVector, rotor: Direction, flux: Scalar, inductance_d: Scalar, inductance_q: Scalar
) -> StatorVector:
    """Current [A] in the stator's axes from a flux linkage.

    Args: linkage: of the stator [V*s]; flux: linkage of the magnets [V*s]; inductance_d, inductance_q: along and across
    the rotor flux [H].
    """
    own = park(linkage, rotor)
    return inverse_park(RotorVector((own.d - flux) / inductance_d, own.q / inductance_q), rotor)


def cogging_torque(rotor: Direction, amplitude: Scalar) -> Scalar:
    """Cogging torque [N*m] of the slots: the sixth harmonic of the electrical angle.

    Source: least common multiple of slots and poles; six per electrical turn for 3 slots per pole pair, the usual
    concentrated winding.

    Args: amplitude [N*m].
    """
    twice = 2.0 * rotor.sine * rotor.cosine
    return amplitude * twice * (3.0 - 4.0 * twice * twice)


def pursuit_curvature(offset_ahead: Scalar, reach: Scalar) -> Scalar:
    """Curvature [1/m] of the arc that meets a straight path at a look-ahead distance.

    Source: pure pursuit; Amidi, Integrated Mobile Robot Control, CMU-RI-TR-90-17 (1990): 2 x / L^2.

    Args: offset_ahead: lateral offset from the path at that distance if the course stayed as it is, positive to the
    left [m]; reach: look-ahead distance [m], positive.
    """
    return -2.0 * offset_ahead / (reach * reach)


def steady_road_wheel_angle(curvature: Scalar, speed: Scalar, wheelbase: Scalar, gradient: Scalar) -> Scalar:
    """Road-wheel angle [rad] that holds a curvature in a steady turn.

    Args: curvature: of the path, positive to the left [1/m]; speed: forward speed [m/s]; wheelbase [m]; gradient: from
    `understeer_gradient` [rad*s**2/m].
    """
    return (wheelbase + gradient * speed * speed) * curvature


def smooth_coulomb(rate: Scalar, level: Scalar, width: Scalar) -> Scalar:
    """Dry friction torque [N*m] smoothed by a hyperbolic tangent, so that it has a derivative.

    Validity: rates well above the width; creeps at standstill.
    """
    return level * tanh(rate / width)
