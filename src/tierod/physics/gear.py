"""Gears between a motor and a shaft: elastic meshing, superposition of two turns."""

from __future__ import annotations

from tierod.core.block import Scalar


def gear_coupling_torque(motor_angle: Scalar, shaft_angle: Scalar, ratio: Scalar, stiffness: Scalar) -> Scalar:
    """Torque [N*m] that an elastic gear takes from the motor; the shaft gets it times the ratio.

    Args:
        motor_angle: of the motor [rad]
        shaft_angle: of the shaft [rad]
        ratio: turns of the motor per turn of the shaft, tau [-]
        stiffness: seen at the motor, k* [N*m/rad]

    Source: Raffone, eqs (2) and (3), printed without the ratio on the side of the shaft and with the wrong sign on that
    of the motor, corrected.
    """
    return stiffness * (motor_angle - ratio * shaft_angle)


def superposed_angle(motor_angle: Scalar, input_angle: Scalar, motor_ratio: Scalar, input_ratio: Scalar) -> Scalar:
    """Angle of the pinion [rad] behind a planetary gear with two inputs; rates superpose alike.

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
    """Wanted turn of the pinion [-] per turn that the steering wheel gives it without motor, over the speed.

    It falls from one gain to the other and passes the mean of both at the middle speed:
    fast + (standing - fast) / (1 + (v / v_middle)^2).

    Args:
        speed: of the vehicle, v_X [m/s]
        standing, fast: gains at rest and at very high speed [-]
        middle_speed: above zero [m/s]

    Source: Reinelt et al., eq (4), which leaves the ratio open; this course of it is assumed.
    """
    share = speed / middle_speed
    return fast + (standing - fast) / (1.0 + share * share)


def superposed_target(input_angle: Scalar, gain: Scalar, motor_ratio: Scalar, input_ratio: Scalar) -> Scalar:
    """Angle of the motor [rad] that makes the pinion turn by `gain` times what the steering wheel gives it.

    Args:
        input_angle: of the shaft from the steering wheel, delta_S [rad]
        gain: of `variable_gain` [-]
        motor_ratio: turns of the motor per turn of the pinion, i_M [-]
        input_ratio: turns of the shaft per turn of the pinion, i_D [-]

    Source: Reinelt et al., eqs (1) and (4), solved for delta_Md.
    """
    return motor_ratio * (gain - 1.0) / input_ratio * input_angle
