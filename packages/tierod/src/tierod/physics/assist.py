"""The assist characteristic: assist torque as a function of the driver's torque and of the speed."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, absolute, limit, maximum, minimum, sign


def assist_speed_factor(speed: Number, half_speed: Scalar) -> Number:
    """Assist at a speed over the assist at rest [-]: 1 at rest, 1/2 at the half speed.

    Args:
        speed: forward speed [m/s]
        half_speed: speed at which assist has fallen to a half [m/s]
    """
    return 1.0 / (1.0 + absolute(speed) / half_speed)


def assist_torque(
    driver_torque: Number,
    speed: Scalar,
    linear_gain: Scalar,
    quadratic_gain: Scalar,
    dead_band: Scalar,
    half_speed: Scalar,
    maximum_torque: Scalar,
) -> Number:
    """Assist torque [N*m] at the column, in the direction of the driver's torque.

    Args:
        driver_torque: torque in the torsion bar [N*m]
        speed: forward speed [m/s]
        linear_gain: assist per driver torque just outside the dead band, at rest [-]
        quadratic_gain: growth of the gain with the driver's torque [1/(N*m)]
        dead_band: driver torque without assist [N*m]
        half_speed: speed at which assist has fallen to a half [m/s]
        maximum_torque: limit of the motor, referred to the column [N*m]

    A parabola outside a dead band with saturation, the "curved characteristic" of Badawy, Zuraski, Bolourchi and
    Chandy, SAE 1999-01-0399; the speed dependence is an assumption of ours.
    """
    effort = maximum(absolute(driver_torque) - dead_band, 0.0)
    wanted = assist_speed_factor(speed, half_speed) * effort * (linear_gain + quadratic_gain * effort)
    return sign(driver_torque) * minimum(wanted, maximum_torque)


def active_return_torque(
    angle: Scalar, rate: Scalar, return_rate_gain: Scalar, maximum_rate: Scalar, gain: Scalar
) -> Scalar:
    """Torque [N*m] at the column that returns a released steering wheel at a reference rate.

    Args:
        angle: of the steering wheel [rad]
        rate: of the steering wheel [rad/s]
        return_rate_gain: reference rate per angle [1/s]
        maximum_rate: limit of the reference rate [rad/s]
        gain: torque per rate error [N*m*s/rad]

    A proportional controller of the rate, whose reference is an assumption of ours; production units use angle and
    rate alike.
    """
    wanted = limit(-return_rate_gain * angle, -maximum_rate, maximum_rate)
    return gain * (wanted - rate)


def active_return_share(speed: Scalar, driver_torque: Scalar, best_speed: Scalar, fade_torque: Scalar) -> Scalar:
    """Factor [-] of the active return: 0 at rest, 1 at the best speed, less above it and under driver torque.

    Args:
        speed: forward speed [m/s]
        driver_torque: torque in the torsion bar [N*m]
        best_speed: speed at which the steering needs most torque to return [m/s]
        fade_torque: driver torque at which the factor has fallen to a half [N*m]

    An assumption of ours: 2 x / (1 + x^2) over the relative speed, 1 / (1 + y^2) over the relative torque.
    """
    relative, effort = absolute(speed) / best_speed, driver_torque / fade_torque
    return 2.0 * relative / ((1.0 + relative * relative) * (1.0 + effort * effort))
