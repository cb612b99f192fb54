"""What can be seen of a steering at one instant; every steering with a steering wheel and one motor gives the same."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple


class SteeringSignals(NamedTuple):
    """Signals before sensors, and what no sensor sees (`truth_`)."""

    steering_wheel_angle: Annotated[Any, "rad"]
    steering_wheel_rate: Annotated[Any, "rad/s"]
    driver_torque: Annotated[Any, "N*m"]
    motor_torque: Annotated[Any, "N*m"]
    motor_angle_mechanical: Annotated[Any, "rad"]
    motor_speed: Annotated[Any, "rad/s"]
    pinion_angle: Annotated[Any, "rad"]
    rack_position: Annotated[Any, "m"]
    rack_speed: Annotated[Any, "m/s"]
    rack_force: Annotated[Any, "N"]
    tie_rod_force_left: Annotated[Any, "N"]
    tie_rod_force_right: Annotated[Any, "N"]
    road_wheel_angle_left: Annotated[Any, "rad"]
    road_wheel_angle_right: Annotated[Any, "rad"]
    truth_friction_torque: Annotated[Any, "N*m"]
    truth_friction_resistance: Annotated[Any, "N*m"]
    truth_steering_wheel_acceleration: Annotated[Any, "rad/s**2"]
