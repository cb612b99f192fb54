"""Parameters, states and axle forces of the lateral motion of a car."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import maximum, sin, sqrt
from tierod.physics.magic_formula import magic_angle

UNKNOWNS: dict[str, str] = {
    "log_front_stiffness": "",
    "log_rear_stiffness": "",
    "log_friction": "",
    "bank_angle": "rad",
    "side_force": "N",
    "side_moment": "N*m",
    "lateral_acceleration_bias": "m/s**2",
    "yaw_rate_bias": "rad/s",
    "road_wheel_angle_offset": "rad",
    "log_steering_friction": "",
    "log_trail": "",
}
"""Possible states beside the motion, with units; `log_` is the natural logarithm of the true over the given value."""

OF_STEERING = ("log_steering_friction", "log_trail")  # Unknowns that need the steering among the states


@dataclass(frozen=True)
class LateralParameters:
    """Parameters of a car for the sideslip estimator, named as in a vehicle file."""

    mass: Annotated[float, "kg"]  # mass, yaw_inertia: of the vehicle
    yaw_inertia: Annotated[float, "kg*m**2"]
    front_distance: Annotated[float, "m"]  # front_distance, rear_distance: from the centre of gravity to the axles
    rear_distance: Annotated[float, "m"]
    # front_cornering_stiffness, rear_cornering_stiffness: of the axles at their static load
    front_cornering_stiffness: Annotated[float, "N/rad"]
    rear_cornering_stiffness: Annotated[float, "N/rad"]
    centre_height: Annotated[float, "m"] = 0.5  # of the centre of gravity, above ground
    # of the front axle's lateral force; shorter than that of the tyre, because of the compliance of the suspension,
    # which acts later
    relaxation_length: Annotated[float, "m"] = 0.3
    rear_relaxation_ratio: Annotated[float, ""] = 1.0  # relaxation length of the rear axle over that of the front axle
    tyre_friction: Annotated[float, ""] = 1.0  # peak lateral force over load of the front axle on a dry road
    rear_friction_ratio: Annotated[float, ""] = 1.0  # friction of the rear axle over that of the front axle
    # front_force_shape, rear_force_shape: C of the Magic Formula of the axles, with the compliance of the suspension;
    # the higher, the longer the force stays linear
    front_force_shape: Annotated[float, ""] = 1.4
    rear_force_shape: Annotated[float, ""] = 1.4
    # Ct of the pneumatic trail; above the force's shape the trail vanishes before the peak of the force
    trail_shape: Annotated[float, ""] = 1.15
    # load transferred to the outer front wheel per lateral force of the axle; the pneumatic trail grows with the load
    front_load_transfer: Annotated[float, ""] = 0.3
    # relative growth of the cornering stiffness per relative growth of the load
    stiffness_growth: Annotated[float, ""] = 0.6
    mechanical_trail: Annotated[float, "m"] = 0.023  # of the front axle
    pneumatic_trail: Annotated[float, "m"] = 0.03  # of both axles, without slip
    # component of gravity in the measured lateral acceleration by roll, per acceleration
    roll_share: Annotated[float, ""] = 0.05
    # roll_frequency, roll_damping_ratio: natural frequency and damping ratio of the body's roll
    roll_frequency: Annotated[float, "rad/s"] = 14.0
    roll_damping_ratio: Annotated[float, ""] = 0.4
    roll_arm: Annotated[float, "m"] = 0.4  # height of the centre of gravity above the roll axis
    sensor_forward: Annotated[float, "m"] = 0.0  # distance of the accelerometer ahead of the centre of gravity
    # drive_front_share, brake_front_share: share of the longitudinal force at the front axle
    drive_front_share: Annotated[float, ""] = 0.5
    brake_front_share: Annotated[float, ""] = 0.65
    road_wheel_inertia: Annotated[float, "kg*m**2"] = 3.5  # of everything that turns with the road wheels, J_w
    road_wheel_damping: Annotated[float, "N*m*s/rad"] = 160.0  # viscous, at the road wheels, b_w
    road_wheel_friction: Annotated[float, "N*m"] = 30.0  # level of dry friction at the road wheels, F_w
    # angle over which that friction builds up linearly; 3/4 of the angle of Dahl's law
    road_wheel_friction_angle: Annotated[float, "rad"] = 1.3e-3


@dataclass(frozen=True)
class Sampled:
    """Parameters of the sampled model."""

    car: LateralParameters  # as in the vehicle file
    sample_time: Annotated[float, "s"]  # sampling interval
    usual: tuple[float, ...] = ()  # value to which every unknown returns, in their order
    fading: tuple[float, ...] = ()  # share of the deviation from it that is left after a sample; one for a random walk


LEAST_ACROSS = 0.3
"""Smallest share of the friction that is left for the lateral force under braking [-], so that it stays positive."""


class AxleLoad(NamedTuple):
    """Loads of an axle: vertical force [N], static vertical force [N], and force along the wheels [N]."""

    vertical: Scalar
    static: Scalar
    longitudinal: Scalar


class AxleForce(NamedTuple):
    """Force across the wheels [N], its largest possible value [N], angle inside the Magic Formula [rad]."""

    lateral: Scalar
    greatest: Scalar
    angle: Scalar


def axle_force(
    slip: Scalar, stiffness: Scalar, friction: Scalar, shape: Scalar, load: AxleLoad, growth: Scalar
) -> AxleForce:
    """Lateral force of an axle, and the other fields of `AxleForce`.

    Args:
        slip: tangent of the slip angle, positive where the force is to the left [-]
        stiffness: cornering stiffness at the static load [N/rad]
        friction: peak force over load [-], positive
        shape: C of the Magic Formula [-], above 1; its curvature E is zero
        growth: relative growth of the stiffness per relative growth of the load [-]

    The slip is scaled so that the slope at zero is the stiffness for any friction (similarity); the force along the
    wheels reduces the lateral friction by the friction ellipse.
    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed., sections 4.2 and 4.3.
    """
    grip = friction * load.vertical
    used = load.longitudinal / grip
    greatest = grip * sqrt(maximum(1.0 - used * used, LEAST_ACROSS * LEAST_ACROSS))
    slope = stiffness * (1.0 + growth * (load.vertical / load.static - 1.0))
    angle = magic_angle(slope / (shape * greatest) * slip, 0.0)
    return AxleForce(greatest * sin(shape * angle), greatest, angle)


class Body(NamedTuple):
    """Lateral speed of the centre of gravity, yaw rate, and the lateral deflections of the axles' tyres."""

    lateral_speed: Annotated[float, "m/s"]
    yaw_rate: Annotated[float, "rad/s"]
    front_deflection: Annotated[float, "m"]
    rear_deflection: Annotated[float, "m"]


class Roll(NamedTuple):
    """Roll of the body, positive with the right side down."""

    roll_angle: Annotated[float, "rad"]
    roll_rate: Annotated[float, "rad/s"]


class Steering(NamedTuple):
    """Mean steer of the road wheels, its rate, and dry friction over its level."""

    road_wheel_angle: Annotated[float, "rad"]
    road_wheel_rate: Annotated[float, "rad/s"]
    friction_share: Annotated[float, ""]


class Driven(NamedTuple):
    """Inputs of a car with known steering angle: speed, longitudinal acceleration, mean steer of the road wheels."""

    vehicle_speed: Annotated[float, "m/s"]
    longitudinal_acceleration: Annotated[float, "m/s**2"]
    road_wheel_angle: Annotated[float, "rad"]


class DrivenByWire(NamedTuple):
    """Inputs of a car with the steering as states; its rate is held while the torque is unknown (`torque_known` 0)."""

    vehicle_speed: Annotated[float, "m/s"]
    longitudinal_acceleration: Annotated[float, "m/s**2"]
    road_wheel_torque: Annotated[float, "N*m"]
    torque_known: Annotated[float, ""]


class Measured(NamedTuple):
    """Measurements of an inertial unit."""

    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]


class MeasuredByWire(NamedTuple):
    """Measurements of an inertial unit and the angle sensor of the road wheels."""

    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    road_wheel_angle: Annotated[float, "rad"]


class Forces(NamedTuple):
    """Forces of both axles and the torque that they make about the kingpins."""

    front: AxleForce  # front, rear: forces across the wheels
    rear: AxleForce
    front_across: Scalar  # front_across, rear_across: forces across the body [N]
    rear_across: Scalar
    front_slip: Scalar  # front_slip, rear_slip: tangents of the effective slip angles [-]
    rear_slip: Scalar
    pneumatic_trail: Scalar  # pneumatic_trail, rear_trail: pneumatic trails of the axles [m]
    rear_trail: Scalar
    self_aligning_torque: Scalar  # of the front axle, opposing positive steer [N*m]
