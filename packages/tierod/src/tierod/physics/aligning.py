"""Self-aligning torques: of the tyres, and of the inclined steering axis."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import cos, sin


def aligning_torque_from_steer(
    steering_wheel_angle: Scalar,
    lateral_acceleration: Scalar,
    yaw_rate: Scalar,
    speed: Scalar,
    *,
    mass: Scalar,
    wheelbase: Scalar,
    front_stiffness: Scalar,
    rear_stiffness: Scalar,
    trail: Scalar,
    steering_ratio: Scalar,
) -> Scalar:
    """Self-aligning torque [N*m] of the linear single track from angle, lateral acceleration and yaw rate.

    Args:
        steering_wheel_angle: [rad]
        lateral_acceleration: at the centre of gravity, without the component of gravity [m/s**2]
        yaw_rate: [rad/s]
        speed: forward speed [m/s], above 3
        mass: of the vehicle [kg]
        wheelbase: [m]; the paper calls it vehicle length
        front_stiffness: cornering stiffness of the front axle [N/rad]
        rear_stiffness: cornering stiffness of the rear axle [N/rad]
        trail: pneumatic and mechanical trail together, lp [m]
        steering_ratio: road-wheel angle per steering-wheel angle, rho, about 1/15 [-]

    Validity: linear tyres.
    Source: Mohtat et al., eq (1), corrected: the last numerator is Cr (printed Cf), and the sign is plus (printed
    minus), since eqs (2) to (4) take the torque as resisting: Mz = lp Cf/(Cf+Cr) (m ay + Cr rho theta - Cr L r/v).
    """
    lateral_force = (
        front_stiffness
        / (front_stiffness + rear_stiffness)
        * (
            mass * lateral_acceleration
            + rear_stiffness * steering_ratio * steering_wheel_angle
            - rear_stiffness * wheelbase * yaw_rate / speed
        )
    )
    return trail * lateral_force


def aligning_torque_from_yaw(
    lateral_acceleration: Scalar,
    yaw_acceleration: Scalar,
    *,
    mass: Scalar,
    yaw_inertia: Scalar,
    front_distance: Scalar,
    rear_distance: Scalar,
    trail: Scalar,
) -> Scalar:
    """Self-aligning torque [N*m] from the balance of forces and moments, without a tyre model.

    Args:
        lateral_acceleration: at the centre of gravity, without the component of gravity [m/s**2]
        yaw_acceleration: [rad/s**2]
        mass: of the vehicle [kg]
        yaw_inertia: about the vertical axis [kg*m**2]
        front_distance: from the centre of gravity to the front axle [m]
        rear_distance: from the centre of gravity to the rear axle [m]
        trail: pneumatic and mechanical trail together, lp [m]

    Source: Mohtat et al., eq (4); lp includes the mechanical trail, which the paper leaves unmentioned.
    """
    return trail * front_force_from_motion(
        lateral_acceleration,
        yaw_acceleration,
        mass=mass,
        yaw_inertia=yaw_inertia,
        front_distance=front_distance,
        rear_distance=rear_distance,
    )


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

    Args:
        lateral_acceleration: at the centre of gravity, without the component of gravity [m/s**2]
        yaw_acceleration: [rad/s**2]
        mass: of the vehicle [kg]
        yaw_inertia: about the vertical axis [kg*m**2]
        front_distance: from the centre of gravity to the front axle [m]
        rear_distance: from the centre of gravity to the rear axle [m]

    Source: Mohtat et al., eqs (3) and (4) without the trail: Fyf = (Lr m ay + Iz psi'') / (Lf + Lr).
    """
    moment = rear_distance * mass * lateral_acceleration + yaw_inertia * yaw_acceleration
    return moment / (front_distance + rear_distance)


def longitudinal_force_from_motion(
    acceleration: Scalar, yaw_rate: Scalar, *, mass: Scalar, rear_distance: Scalar
) -> Scalar:
    """Longitudinal force [N] of all tyres for a motion on level ground, without drag and rolling resistance.

    Args:
        acceleration: rate of change of the forward speed [m/s**2]
        yaw_rate: [rad/s]
        mass: of the vehicle [kg]
        rear_distance: from the centre of gravity to the rear axle [m]

    The lateral speed of the centre of gravity is the yaw rate times its distance from the rear axle.
    Validity: rear axle without side slip.
    """
    return mass * (acceleration - rear_distance * yaw_rate * yaw_rate)


def force_across_wheels(lateral_force: Scalar, longitudinal_force: Scalar, steer: Scalar) -> Scalar:
    """Force [N] of the front axle across its steered wheels, which acts on the trail.

    Args:
        lateral_force: of the front axle across the body [N]
        longitudinal_force: of the front axle along the body [N]
        steer: of the wheels [rad]
    """
    return cos(steer) * lateral_force - sin(steer) * longitudinal_force


def yaw_acceleration_from_aligning(
    self_aligning_torque: Scalar,
    lateral_acceleration: Scalar,
    *,
    mass: Scalar,
    yaw_inertia: Scalar,
    front_distance: Scalar,
    rear_distance: Scalar,
    trail: Scalar,
) -> Scalar:
    """Yaw acceleration [rad/s**2] from the self-aligning torque: eq (4) solved for the yaw acceleration.

    Args:
        self_aligning_torque: about the kingpins [N*m]
        lateral_acceleration: at the centre of gravity, without the component of gravity [m/s**2]
        mass: of the vehicle [kg]
        yaw_inertia: about the vertical axis [kg*m**2]
        front_distance: from the centre of gravity to the front axle [m]
        rear_distance: from the centre of gravity to the rear axle [m]
        trail: pneumatic and mechanical trail together, lp [m]

    Source: Mohtat et al., third row of eq (7): psi'' = (L/(lp Iz)) Mz - (Lr m/Iz) ay.
    """
    wheelbase = front_distance + rear_distance
    front_moment = wheelbase / trail * self_aligning_torque
    return (front_moment - rear_distance * mass * lateral_acceleration) / yaw_inertia


def weight_lever(scrub_radius: Scalar, inclination: Scalar, wheel_radius: Scalar) -> Scalar:
    """Lever [m] of the wheel load in the self-centring torque about the kingpin.

    Args:
        scrub_radius: from the kingpin axis, at the ground, outward to the wheel plane [m]
        inclination: of the kingpin axis, its upper end inward [rad]
        wheel_radius: [m]

    A narrow rigid wheel that turns about an inclined axis lifts the car by rho sin(i) (1 - cos(steer)), where
    rho = s cos(i) + R sin(i) is the distance of the hub from the axis.
    Validity: without caster; the round shoulders of a wide tyre reduce it.
    """
    return (scrub_radius * cos(inclination) + wheel_radius * sin(inclination)) * sin(inclination)


def weight_torque(load: Scalar, lever: Scalar, sine: Scalar) -> Scalar:
    """Torque [N*m] of the wheel load about one kingpin, from the work of lifting the car.

    Args:
        load: of the wheel [N]
        lever: from `weight_lever` [m]
        sine: of the steer [-]
    """
    return load * lever * sine


def scrub_radius_torque(left_force: Scalar, right_force: Scalar, scrub_radius: Scalar) -> tuple[Scalar, Scalar]:
    """Torques [N*m] about the left and right kingpin of drive and brake forces at the ground.

    Args:
        left_force, right_force: of the tyres along their wheels, forward [N]
        scrub_radius: from the kingpin axis, at the ground, outward to the wheel plane [m]

    Validity: brakes and motors inside the wheel, so that their torque acts on the knuckle.
    """
    return scrub_radius * left_force, -scrub_radius * right_force
