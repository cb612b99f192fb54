"""From the steering wheel to the road wheels: steering ratio, Ackermann angles, and the torsion bar.

A ratio here is road-wheel angle per steering-wheel angle (about 1/15), the rho of Mohtat et al., eq (2). By virtual
work the same number turns a torque about the kingpin into a torque at the steering wheel.
"""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, absolute, arcsin, exp, log, minimum, sign, sin, sqrt, where


def variable_ratio(steering_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar) -> Scalar:
    """Ratio [-] of a rack that becomes more direct away from the centre.

    Args:
        steering_wheel_angle: [rad]
        centre_ratio: ratio at the centre [-]
        growth: relative growth with the squared angle [1/rad**2]; zero is a constant ratio
    """
    return centre_ratio * (1.0 + growth * steering_wheel_angle * steering_wheel_angle)


def variable_ratio_slope(steering_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar) -> Scalar:
    """Derivative of `variable_ratio` with respect to the angle [1/rad], rho' of Mohtat et al., eq (19).

    Args:
        steering_wheel_angle: [rad]
        centre_ratio: ratio at the centre [-]
        growth: relative growth with the squared angle [1/rad**2]
    """
    return 2.0 * centre_ratio * growth * steering_wheel_angle


def road_wheel_angle(steering_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar = 0.0) -> Scalar:
    """Mean steer [rad] of the front wheels: the integral of the ratio over the steering-wheel angle.

    Args:
        steering_wheel_angle: [rad]
        centre_ratio: ratio at the centre [-]
        growth: relative growth of the ratio with the squared angle [1/rad**2]
    """
    return centre_ratio * steering_wheel_angle * (1.0 + growth / 3.0 * steering_wheel_angle * steering_wheel_angle)


def pinion_angle(road_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar = 0.0) -> Scalar:
    """Angle of the pinion [rad] for a mean steer of the front wheels: the inverse of `road_wheel_angle`.

    Args:
        road_wheel_angle: mean steer of the front wheels, delta_F [rad]
        centre_ratio: ratio at the centre [-]
        growth: relative growth of the ratio with the squared angle [1/rad**2]

    Validity: with a negative growth, below the angle at which the ratio is zero.
    Source: Reinelt et al., eq (2), delta_G = F_SG(delta_F), with an assumed function F_SG; the real root of its cubic
    by the triple-angle formula of the hyperbolic sine (growth above zero) or of the sine (below).
    """
    straight = road_wheel_angle / centre_ratio
    # All three solutions are evaluated whatever the growth, so every root and arcsine needs a valid argument.
    bent = absolute(growth) > 1e-12
    root = sqrt(where(bent, absolute(growth), 1.0))
    third = 1.5 * root * absolute(straight)
    raised = log(third + sqrt(1.0 + third * third)) / 3.0
    direct = exp(raised) - exp(-raised)  # twice the hyperbolic sine
    falling = 2.0 * sin(arcsin(minimum(third, 1.0)) / 3.0)
    size = where(growth > 0.0, direct, falling) / root
    return where(bent, sign(straight) * size, straight)


def road_wheel_angle_of_ratio(steering_wheel_angle: Scalar, overall_ratio: Scalar) -> Scalar:
    """Mean steer of the front wheels [rad] for an overall ratio.

    Args:
        steering_wheel_angle: delta_S [rad]
        overall_ratio: steering wheel angle per mean steer, i_V [-]; set as a function of speed and pinion angle (eq 4)

    Source: Reinelt et al., eq (3).
    """
    return steering_wheel_angle / overall_ratio


def torque_at_steering_wheel(kingpin_torque: Number, ratio: Scalar) -> Number:
    """Torque [N*m] at the steering wheel from a torque about the kingpins, without losses.

    Args:
        kingpin_torque: about the kingpins [N*m]
        ratio: road-wheel angle per steering-wheel angle at this angle [-]

    Source: virtual work; Mohtat et al., eq (2), term rho Mz.
    """
    return ratio * kingpin_torque


def column_torque_of_motor(motor_torque: Number, gear_ratio: Scalar) -> Number:
    """Torque [N*m] of an assist motor at the column, without losses.

    Args:
        motor_torque: at the motor shaft [N*m], Kt times current
        gear_ratio: motor angle per steering-wheel angle, n [-]

    Source: Mohtat et al., eqs (2), (7) and (16): n Kt i = n Tm; Kt is not applied a second time.
    """
    return gear_ratio * motor_torque


def ackermann_angle(mean_angle: Scalar, gain: Scalar) -> Scalar:
    """Steer [rad] of the left front wheel; the right one has the gain with the other sign.

    Args:
        mean_angle: mean steer of both front wheels [rad], positive left
        gain: half the difference of both wheels per squared steer [1/rad]; track / (2 wheelbase) lets all wheels roll
            about one centre (full Ackermann), zero keeps the wheels parallel

    Validity: the second order of cot(right) - cot(left) = track / wheelbase; the difference of both wheels is 5 % too
    large at 0.35 rad and 11 % at 0.5 rad.
    Source: Rajamani, Vehicle Dynamics and Control (2012), section 2.2:
    the difference of both wheels is steer^2 track / wheelbase.
    """
    return mean_angle + gain * mean_angle * mean_angle


def ackermann_slope(mean_angle: Scalar, gain: Scalar) -> Scalar:
    """Derivative of `ackermann_angle` with respect to the mean steer [-].

    Args:
        mean_angle: mean steer of both front wheels [rad]
        gain: as in `ackermann_angle` [1/rad]
    """
    return 1.0 + 2.0 * gain * mean_angle


def torsion_bar_torque(
    wheel_angle: Scalar,
    pinion_angle: Scalar,
    stiffness: Scalar,
    wheel_rate: Scalar = 0.0,
    pinion_rate: Scalar = 0.0,
    damping: Scalar = 0.0,
) -> Scalar:
    """Torque [N*m] of the bar on the pinion, positive towards left; it acts on the wheel with the other sign.

    Args:
        wheel_angle: angle of the steering wheel [rad]
        pinion_angle: angle of the pinion [rad]
        stiffness: of the bar [N*m/rad], 80 to 170 in passenger cars
        wheel_rate: rate of the steering wheel [rad/s]
        pinion_rate: rate of the pinion [rad/s]
        damping: of the bar [N*m*s/rad]

    Validity: below the stops of the bar, about 0.08 rad of twist.
    """
    return stiffness * (wheel_angle - pinion_angle) + damping * (wheel_rate - pinion_rate)


def torsion_bar_twist(driver_torque: Number, stiffness: Scalar) -> Number:
    """Twist [rad] of the bar under a torque, the difference of wheel and pinion angle at rest.

    Args:
        driver_torque: torque in the bar [N*m]
        stiffness: of the bar [N*m/rad]
    """
    return driver_torque / stiffness
