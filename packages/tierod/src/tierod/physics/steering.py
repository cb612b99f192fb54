"""Steering: ratios and gears, torsion bar, assist, balance of the rack, and aligning torque.

Arguments, unless a function says otherwise: acceleration: rate of change of the forward speed [m/s**2]; angle: of the
column [rad]; centre_ratio: ratio at the centre [-]; damping: of the bar [N*m*s/rad]; dead_band: driver torque without
assist [N*m]; driver_torque: torque in the bar [N*m]; friction: dry friction at the column, with the sign of the rate
[N*m]; front_distance: from the centre of gravity to the front axle [m]; gain: from `variable_gain` [-]; gear_ratio:
motor angle per steering-wheel angle, n [-]; growth: relative growth of the ratio with the squared angle [1/rad**2];
half_speed: speed at which assist has fallen to a half [m/s]; inclination: of the kingpin axis, its upper end inward
[rad]; input_angle: of the shaft from the steering wheel, delta_S [rad]; input_ratio: turns of the shaft per turn of the
pinion, i_D [-]; kingpin_torque: about the kingpins [N*m]; lateral_acceleration: at the centre of gravity, without the
component of gravity [m/s**2]; lateral_force: of the front axle across the body [N]; lever: from `weight_lever` [m];
linear_gain: assist per driver torque just outside the dead band, at rest [-]; load: of the wheel [N];
longitudinal_force: of the front axle along the body [N]; mass: of the vehicle [kg]; maximum_torque: limit of the motor,
referred to the column [N*m]; middle_speed: above zero [m/s]; motor_angle: of the motor [rad]; motor_ratio: turns of the
motor per turn of the pinion, i_M [-]; motor_torque: at the motor shaft [N*m], Kt times current; pinion_angle: angle of
the pinion [rad]; pinion_rate: rate of the pinion [rad/s]; quadratic_gain: growth of the gain with the driver's torque
[1/(N*m)]; rack_ratio: rack travel per turn of the column [m/rad]; rate: of the column [rad/s]; ratio: road-wheel angle
per steering-wheel angle at this angle [-]; rear_distance: from the centre of gravity to the rear axle [m];
road_wheel_angle: mean steer of the front wheels, delta_F [rad]; scrub_radius: from the kingpin axis, at the ground,
outward to the wheel plane [m]; self_aligning_torque: about the kingpins [N*m]; shaft_angle: of the shaft [rad]; sine:
of the steer [-]; speed: forward speed [m/s]; standing, fast: gains at rest and at very high speed [-]; steer: of the
wheels [rad]; steering_wheel_angle [rad]; stiffness: of the bar [N*m/rad], 80 to 170 in passenger cars; tie_rod_force:
positive where it opposes a turn to the left [N]; torque: at the column, towards the left [N*m]; trail: pneumatic and
mechanical trail together, lp [m]; wheel_angle: angle of the steering wheel [rad]; wheel_radius [m]; wheel_rate: rate of
the steering wheel [rad/s]; yaw_acceleration [rad/s**2]; yaw_inertia: about the vertical axis [kg*m**2]; yaw_rate
[rad/s].
"""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, absolute, arcsin, cos, exp, log, maximum, minimum, sign, sin, sqrt, where


def road_wheel_angle(steering_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar = 0.0) -> Scalar:
    """Mean steer [rad] of the front wheels: the integral of the ratio over the steering-wheel angle."""
    return centre_ratio * steering_wheel_angle * (1.0 + growth / 3.0 * steering_wheel_angle * steering_wheel_angle)


def pinion_angle(road_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar = 0.0) -> Scalar:
    """Angle of the pinion [rad] for a mean steer of the front wheels: the inverse of `road_wheel_angle`.

    Validity: with a negative growth, below the angle at which the ratio is zero. Source: Reinelt et al., eq (2),
    delta_G = F_SG(delta_F), with an assumed function F_SG; the real root of its cubic by the triple-angle formula of
    the hyperbolic sine (growth above zero) or of the sine (below).
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


def torque_at_steering_wheel(kingpin_torque: Number, ratio: Scalar) -> Number:
    """Torque [N*m] at the steering wheel from a torque about the kingpins, without losses.

    Source: virtual work; Mohtat et al., eq (2), term rho Mz.
    """
    return ratio * kingpin_torque


def column_torque_of_motor(motor_torque: Number, gear_ratio: Scalar) -> Number:
    """Torque [N*m] of an assist motor at the column, without losses.

    Source: Mohtat et al., eqs (2), (7) and (16): n Kt i = n Tm; Kt is not applied a second time.
    """
    return gear_ratio * motor_torque


def torsion_bar_torque(
    wheel_angle: Scalar,
    pinion_angle: Scalar,
    stiffness: Scalar,
    wheel_rate: Scalar = 0.0,
    pinion_rate: Scalar = 0.0,
    damping: Scalar = 0.0,
) -> Scalar:
    """Torque [N*m] of the bar on the pinion, positive towards left; it acts on the wheel with the other sign.

    Validity: below the stops of the bar, about 0.08 rad of twist.
    """
    return stiffness * (wheel_angle - pinion_angle) + damping * (wheel_rate - pinion_rate)


def torsion_bar_twist(driver_torque: Number, stiffness: Scalar) -> Number:
    """Twist [rad] of the bar under a torque, the difference of wheel and pinion angle at rest.

    Args: stiffness: of the bar [N*m/rad].
    """
    return driver_torque / stiffness


def gear_coupling_torque(motor_angle: Scalar, shaft_angle: Scalar, ratio: Scalar, stiffness: Scalar) -> Scalar:
    """Torque [N*m] of an elastic gear that loads the motor; times the ratio it drives the shaft.

    Source: Raffone, eqs (2) and (3), printed without the ratio on the side of the shaft and with the wrong sign on that
    of the motor, corrected. Args: ratio: turns of the motor per turn of the shaft, tau [-]; stiffness: referred to the
    motor, k* [N*m/rad].
    """
    return stiffness * (motor_angle - ratio * shaft_angle)


def superposed_angle(motor_angle: Scalar, input_angle: Scalar, motor_ratio: Scalar, input_ratio: Scalar) -> Scalar:
    """Angle of the pinion [rad] behind a planetary gear with two inputs; the same relation holds for rates.

    Source: Reinelt et al., eq (1). By virtual work a torque at the pinion loads the motor with 1/i_M of it, and the
    shaft with 1/i_D. Args: motor_angle: delta_M [rad].
    """
    return motor_angle / motor_ratio + input_angle / input_ratio


def variable_gain(speed: Scalar, standing: Scalar, fast: Scalar, middle_speed: Scalar) -> Scalar:
    """Desired pinion angle over the one that the steering wheel alone would give it [-], as a function of the speed.

    It falls from one gain to the other and passes the mean of both at the middle speed:
    fast + (standing - fast) / (1 + (v / v_middle)^2).

    Source: Reinelt et al., eq (4), which leaves the ratio open; this function is an assumption. Args: speed: of the
    vehicle, v_X [m/s].
    """
    share = speed / middle_speed
    return fast + (standing - fast) / (1.0 + share * share)


def superposed_target(input_angle: Scalar, gain: Scalar, motor_ratio: Scalar, input_ratio: Scalar) -> Scalar:
    """Angle of the motor [rad] that turns the pinion by `gain` times the angle that the steering wheel gives it.

    Source: Reinelt et al., eqs (1) and (4), solved for delta_Md.
    """
    return motor_ratio * (gain - 1.0) / input_ratio * input_angle


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

    Validity: below the frequency at which pinion and rack oscillate against each other (hundreds of hertz). Source: Li,
    Frey, Gauterin, eq (2), both rows added with S = ratio times angle. The first row is printed without the ratio
    before the force of the teeth, which adds newtons to newton metres. Args: stiffness: of the rack towards its centre
    [N/m]; damping: of the rack [N*s/m].
    """
    rack = tie_rod_force + rack_ratio * (stiffness * angle + damping * rate)
    return torque - friction - rack_ratio * rack


def assist_speed_factor(speed: Number, half_speed: Scalar) -> Number:
    """Assist at a speed over the assist at rest [-]: 1 at rest, 1/2 at the half speed."""
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

    A parabola outside a dead band with saturation, the "curved characteristic" of Badawy, Zuraski, Bolourchi and
    Chandy, SAE 1999-01-0399; the speed dependence is an assumption of ours.

    Args: driver_torque: torque in the torsion bar [N*m].
    """
    effort = maximum(absolute(driver_torque) - dead_band, 0.0)
    wanted = assist_speed_factor(speed, half_speed) * effort * (linear_gain + quadratic_gain * effort)
    return sign(driver_torque) * minimum(wanted, maximum_torque)


def front_force_from_motion(
    lateral_acceleration: Scalar,
    yaw_acceleration: Scalar,
    *,
    mass: Scalar,
    yaw_inertia: Scalar,
    front_distance: Scalar,
    rear_distance: Scalar,
) -> Scalar:
    """Lateral force [N] of the front axle from the balance of forces and moments.

    Source: Mohtat et al., eqs (3) and (4) without the trail: Fyf = (Lr m ay + Iz psi'') / (Lf + Lr).
    """
    moment = rear_distance * mass * lateral_acceleration + yaw_inertia * yaw_acceleration
    return moment / (front_distance + rear_distance)


def longitudinal_force_from_motion(
    acceleration: Scalar, yaw_rate: Scalar, *, mass: Scalar, rear_distance: Scalar
) -> Scalar:
    """Longitudinal force [N] of all tyres for a motion on level ground, without drag and rolling resistance.

    The lateral speed of the centre of gravity is the yaw rate times its distance from the rear axle.
    Validity: rear axle without side slip.
    """
    return mass * (acceleration - rear_distance * yaw_rate * yaw_rate)


def force_across_wheels(lateral_force: Scalar, longitudinal_force: Scalar, steer: Scalar) -> Scalar:
    """Force [N] of the front axle across its steered wheels, which acts on the trail."""
    return cos(steer) * lateral_force - sin(steer) * longitudinal_force


def weight_lever(scrub_radius: Scalar, inclination: Scalar, wheel_radius: Scalar) -> Scalar:
    """Lever [m] of the wheel load in the self-centring torque about the kingpin.

    A narrow rigid wheel that turns about an inclined axis lifts the car by rho sin(i) (1 - cos(steer)), where
    rho = s cos(i) + R sin(i) is the distance of the hub from the axis.
    Validity: without caster; the round shoulders of a wide tyre reduce it.
    """
    return (scrub_radius * cos(inclination) + wheel_radius * sin(inclination)) * sin(inclination)


def weight_torque(load: Scalar, lever: Scalar, sine: Scalar) -> Scalar:
    """Torque [N*m] of the wheel load about one kingpin, from the work of lifting the car."""
    return load * lever * sine
