"""What goes into the virtual car, what it carries on, and what comes out, one leaf per number."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from tierod.block import Ring


class Surroundings(NamedTuple):
    """What acts on the car from outside at one instant."""

    vehicle_speed: Annotated[float, "m/s"]
    road_curvature: Annotated[float, "1/m"]
    steering_demand: Annotated[float, "rad"]
    friction_torque: Annotated[float, "N*m"]
    on_ground: Annotated[float, ""]


class Wheel(NamedTuple):
    """The steering wheel, where a torsion bar parts it from the column."""

    angle: Any
    rate: Any


class Motion(NamedTuple):
    """What the car's differential equations carry on."""

    column_angle: Any
    column_rate: Any
    motor_torque: Any
    lateral_speed: Any
    yaw_rate: Any
    front_deflection: Any
    rear_deflection: Any
    muscle_angle: Any
    muscle_rate: Any
    persistent_angle: Any
    lateral_offset: Any
    heading_error: Any
    wheel: Any


class State(NamedTuple):
    """The car between two steps."""

    motion: Motion
    friction: Any
    scrub: Any
    seen_offset: Ring


class Output(NamedTuple):
    """Signals of the car before sensors, and what no sensor sees (prefixed `truth_`)."""

    steering_wheel_angle: Annotated[Any, "rad"]
    steering_wheel_rate: Annotated[Any, "rad/s"]
    driver_torque: Annotated[Any, "N*m"]
    motor_torque: Annotated[Any, "N*m"]
    yaw_rate: Annotated[Any, "rad/s"]
    lateral_acceleration: Annotated[Any, "m/s**2"]
    vehicle_speed: Annotated[Any, "m/s"]
    truth_friction_torque: Annotated[Any, "N*m"]
    truth_friction_resistance: Annotated[Any, "N*m"]
    truth_scrub_resistance: Annotated[Any, "N*m"]
    truth_self_aligning_torque: Annotated[Any, "N*m"]
    truth_front_lateral_force: Annotated[Any, "N"]
    truth_sideslip: Annotated[Any, "rad"]
    truth_steering_wheel_acceleration: Annotated[Any, "rad/s**2"]
    truth_lateral_offset: Annotated[Any, "m"]
