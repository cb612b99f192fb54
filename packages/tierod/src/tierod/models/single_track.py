"""The linear single-track (bicycle) model of a vehicle's lateral motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number
from tierod.physics.single_track import (
    front_slip_speed,
    lateral_acceleration,
    rear_slip_speed,
    steady_yaw_gain,
    understeer_gradient,
    yaw_acceleration,
)
from tierod.physics.tyre import linear_lateral_force


class SingleTrack:
    """Lateral motion of a vehicle at small slip angles: one front and one rear axle, linear tyres.

    Validity: |lateral acceleration| below about 4 m/s^2 on a dry road, vehicle_speed above about 3 m/s.
    Source: Mohtat et al., the model behind eqs (1) and (3); C_f and C_r are values of an axle, not of a wheel.
    """

    class State(NamedTuple):
        """Sideslip angle at the centre of gravity and yaw rate."""

        sideslip_angle: Annotated[float, "rad"]
        yaw_rate: Annotated[float, "rad/s"]

    class Input(NamedTuple):
        """Mean steer of the front wheels and forward speed."""

        road_wheel_angle: Annotated[float, "rad"]
        vehicle_speed: Annotated[float, "m/s"]

    class Output(NamedTuple):
        """Measurements of an inertial measurement unit at the centre of gravity."""

        yaw_rate: Annotated[float, "rad/s"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    @dataclass(frozen=True)
    class Parameters:
        """Mass, geometry and axle stiffness."""

        mass: Annotated[float, "kg"]  # of the vehicle [kg]
        yaw_inertia: Annotated[float, "kg*m**2"]  # about the vertical axis through the centre of gravity [kg m^2]
        front_distance: Annotated[float, "m"]  # centre of gravity to front axle [m]
        rear_distance: Annotated[float, "m"]  # centre of gravity to rear axle [m]
        front_cornering_stiffness: Annotated[float, "N/rad"]  # both front tyres together [N/rad]
        rear_cornering_stiffness: Annotated[float, "N/rad"]  # both rear tyres together [N/rad]

    @staticmethod
    def derivative(x: State, u: Input, p: Parameters) -> State:
        """Rates of the sideslip angle and of the yaw rate, from eq (3) and linear axle forces."""
        front, rear = SingleTrack.axle_forces(x, u, p)
        sideslip_rate = lateral_acceleration(front, rear, p.mass) / u.vehicle_speed - x.yaw_rate
        return SingleTrack.State(
            sideslip_rate, yaw_acceleration(front, rear, p.yaw_inertia, p.front_distance, p.rear_distance)
        )

    @staticmethod
    def output(x: State, u: Input, p: Parameters) -> Output:
        front, rear = SingleTrack.axle_forces(x, u, p)
        return SingleTrack.Output(x.yaw_rate, lateral_acceleration(front, rear, p.mass))

    @staticmethod
    def axle_forces(x: State, u: Input, p: Parameters) -> tuple[Scalar, Scalar]:
        """Lateral forces of the front and the rear axle [N], positive in a left turn."""
        speed, lateral_speed = u.vehicle_speed, u.vehicle_speed * x.sideslip_angle
        front = front_slip_speed(lateral_speed, x.yaw_rate, speed, u.road_wheel_angle, p.front_distance) / speed
        rear = rear_slip_speed(lateral_speed, x.yaw_rate, p.rear_distance) / speed
        return (
            linear_lateral_force(front, p.front_cornering_stiffness),
            linear_lateral_force(rear, p.rear_cornering_stiffness),
        )

    @staticmethod
    def steady_yaw_gain(speed: Number, p: Parameters) -> Number:
        """Yaw rate per road-wheel angle [1/s] in a steady turn at a speed [m/s]."""
        gradient = understeer_gradient(
            p.mass, p.front_distance, p.rear_distance, p.front_cornering_stiffness, p.rear_cornering_stiffness
        )
        return steady_yaw_gain(speed, p.front_distance + p.rear_distance, gradient)
