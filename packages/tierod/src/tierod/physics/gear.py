"""Gears and rack: elastic meshing, superposed rotations, backlash, end stops, and the balance of a stiff rack."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, maximum, sign, where


def gear_coupling_torque(motor_angle: Scalar, shaft_angle: Scalar, ratio: Scalar, stiffness: Scalar) -> Scalar:
    """Torque [N*m] of an elastic gear that loads the motor; times the ratio it drives the shaft.

    Args:
        motor_angle: of the motor [rad]
        shaft_angle: of the shaft [rad]
        ratio: turns of the motor per turn of the shaft, tau [-]
        stiffness: referred to the motor, k* [N*m/rad]

    Source: Raffone, eqs (2) and (3), printed without the ratio on the side of the shaft and with the wrong sign on that
    of the motor, corrected.
    """
    return stiffness * (motor_angle - ratio * shaft_angle)


def superposed_angle(motor_angle: Scalar, input_angle: Scalar, motor_ratio: Scalar, input_ratio: Scalar) -> Scalar:
    """Angle of the pinion [rad] behind a planetary gear with two inputs; the same relation holds for rates.

    Args:
        motor_angle: delta_M [rad]
        input_angle: of the shaft from the steering wheel, delta_S [rad]
        motor_ratio: turns of the motor per turn of the pinion, i_M [-]
        input_ratio: turns of the shaft per turn of the pinion, i_D [-]

    Source: Reinelt et al., eq (1). By virtual work a torque at the pinion loads the motor with 1/i_M of it, and the
    shaft with 1/i_D.
    """
    return motor_angle / motor_ratio + input_angle / input_ratio


def variable_gain(speed: Scalar, standing: Scalar, fast: Scalar, middle_speed: Scalar) -> Scalar:
    """Desired pinion angle over the one that the steering wheel alone would give it [-], as a function of the speed.

    It falls from one gain to the other and passes the mean of both at the middle speed:
    fast + (standing - fast) / (1 + (v / v_middle)^2).

    Args:
        speed: of the vehicle, v_X [m/s]
        standing, fast: gains at rest and at very high speed [-]
        middle_speed: above zero [m/s]

    Source: Reinelt et al., eq (4), which leaves the ratio open; this function is an assumption.
    """
    share = speed / middle_speed
    return fast + (standing - fast) / (1.0 + share * share)


def superposed_target(input_angle: Scalar, gain: Scalar, motor_ratio: Scalar, input_ratio: Scalar) -> Scalar:
    """Angle of the motor [rad] that turns the pinion by `gain` times the angle that the steering wheel gives it.

    Args:
        input_angle: of the shaft from the steering wheel, delta_S [rad]
        gain: from `variable_gain` [-]
        motor_ratio: turns of the motor per turn of the pinion, i_M [-]
        input_ratio: turns of the shaft per turn of the pinion, i_D [-]

    Source: Reinelt et al., eqs (1) and (4), solved for delta_Md.
    """
    return motor_ratio * (gain - 1.0) / input_ratio * input_angle


def lash_torque(twist: Scalar, twist_rate: Scalar, stiffness: Scalar, damping: Scalar, play: Scalar) -> Scalar:
    """Torque [N*m] that meshing gears transmit, in the direction of their twist; a force if twist is a distance [m].

    Args:
        twist: of the driving against the driven side [rad], zero in the middle of the play
        twist_rate: its rate [rad/s]
        stiffness: of the flanks in contact [N*m/rad]
        damping: of the flanks in contact [N*m*s/rad]
        play: total backlash from flank to flank [rad]; zero is a meshing without backlash, linear in both directions

    Flanks push and never pull: while they separate, damping ends the contact before the elastic deflection is gone.
    Source: Nordin and Gutman, Automatica 38 (2002) 1633, dead-zone model with damping; the condition on the sign is the
    release condition of their physical model.
    """
    depth = absolute(twist) - 0.5 * play
    direction = sign(twist)
    push = maximum(stiffness * depth + damping * direction * twist_rate, 0.0)
    loose = where(depth > 0.0, direction * push, 0.0)
    return where(play > 0.0, loose, stiffness * twist + damping * twist_rate)


def end_stop_torque(angle: Scalar, rate: Scalar, lock: Scalar, stiffness: Scalar, damping: Scalar) -> Scalar:
    """Torque [N*m] of an elastic, damped stop, positive where it opposes a turn to the left.

    Args:
        angle: [rad]
        rate: [rad/s]
        lock: angle at which either stop makes contact [rad], positive
        stiffness: of the stop [N*m/rad]
        damping: of the stop [N*m*s/rad]

    A stop pushes and never pulls.
    """
    depth = absolute(angle) - lock
    direction = sign(angle)
    push = maximum(stiffness * depth + damping * direction * rate, 0.0)
    return where(depth > 0.0, direction * push, 0.0)


def column_balance(
    torque: Scalar,
    friction: Scalar,
    tie_rod_force: Scalar,
    angle: Scalar,
    rate: Scalar,
    rack_ratio: Scalar,
    stiffness: Scalar,
    damping: Scalar,
) -> Scalar:
    """Torque that accelerates column and rack [N*m]: their inertia at the column times its angular acceleration.

    Args:
        torque: at the column, towards the left [N*m]
        friction: dry friction at the column, with the sign of the rate [N*m]
        tie_rod_force: positive where it opposes a turn to the left [N]
        angle: of the column [rad]
        rate: of the column [rad/s]
        rack_ratio: rack travel per turn of the column [m/rad]
        stiffness: of the rack towards its centre [N/m]
        damping: of the rack [N*s/m]

    Validity: below the frequency at which pinion and rack oscillate against each other (hundreds of hertz).
    Source: Li, Frey, Gauterin, eq (2), both rows added with S = ratio times angle. The first row is printed without the
    ratio before the force of the teeth, which adds newtons to newton metres.
    """
    rack = tie_rod_force + rack_ratio * (stiffness * angle + damping * rate)
    return torque - friction - rack_ratio * rack


def tie_rod_force_of_balance(
    torque: Scalar, friction: Scalar, mass: Scalar, lateral_acceleration: Scalar, per_mass: Scalar, per_torque: Scalar
) -> Scalar:
    """Force of the tie rods [N] as a weighted sum of lateral acceleration and torque.

    Args:
        torque: at the column [N*m]
        friction: dry friction at the column, with the sign of the rate [N*m]
        mass: of the vehicle [kg]
        lateral_acceleration: [m/s**2]
        per_mass: weight of mass times acceleration [-]
        per_torque: force per torque [1/m]; at most the inverse of the rack's travel per radian

    Source: Li, Frey, Gauterin, eq (46), whose friction is printed without the sign of the rate.
    """
    return per_mass * mass * lateral_acceleration + per_torque * (torque - friction)
