"""The gear between steering wheel and road wheels.

A ratio here is road-wheel angle per steering-wheel angle (about 1/15), the rho of Mohtat et al., eq (2). By virtual
work the same number turns a torque about the kingpin into a torque at the steering wheel.
"""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number


def variable_ratio(steering_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar) -> Scalar:
    """Ratio [-] of a rack that becomes more direct away from the centre.

    Args:
        steering_wheel_angle: [rad]
        centre_ratio: ratio at the centre [-]
        growth: relative growth with the squared angle [1/rad**2]; zero is a constant ratio
    """
    return centre_ratio * (1.0 + growth * steering_wheel_angle * steering_wheel_angle)


def road_wheel_angle(steering_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar = 0.0) -> Scalar:
    """Mean steer [rad] of the front wheels: the integral of the ratio over the steering-wheel angle.

    Args:
        steering_wheel_angle: [rad]
        centre_ratio: ratio at the centre [-]
        growth: relative growth of the ratio with the squared angle [1/rad**2]
    """
    return centre_ratio * steering_wheel_angle * (1.0 + growth / 3.0 * steering_wheel_angle * steering_wheel_angle)


def torque_at_steering_wheel(kingpin_torque: Scalar, ratio: Scalar) -> Scalar:
    """Torque [N*m] felt at the steering wheel for a torque about the kingpins, without losses.

    Args:
        kingpin_torque: about the kingpins [N*m]
        ratio: road-wheel angle per steering-wheel angle at this angle [-]

    Source: virtual work; Mohtat et al., eq (2), term rho Mz.
    """
    return ratio * kingpin_torque


def column_torque_of_motor(motor_torque: Number, gear_ratio: Scalar) -> Number:
    """Torque [N*m] at the column of an assist motor, without losses.

    Args:
        motor_torque: at the motor shaft [N*m], Kt times current
        gear_ratio: motor angle per steering-wheel angle, n [-]

    Source: Mohtat et al., eqs (2), (7) and (16): n Kt i = n Tm; Kt is not applied a second time.
    """
    return gear_ratio * motor_torque
