"""States, inputs, outputs and forces of the lateral motion of a car."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.models.axle_force import AxleForce


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
    """Forces of both axles and the torque that they make about the kingpins.

    Args:
        front, rear: forces across the wheels
        front_across, rear_across: forces across the body [N]
        front_slip, rear_slip: tangents of the effective slip angles [-]
        pneumatic_trail, rear_trail: pneumatic trails of the axles [m]
        self_aligning_torque: of the front axle, opposing positive steer [N*m]
    """

    front: AxleForce
    rear: AxleForce
    front_across: Scalar
    rear_across: Scalar
    front_slip: Scalar
    rear_slip: Scalar
    pneumatic_trail: Scalar
    rear_trail: Scalar
    self_aligning_torque: Scalar
