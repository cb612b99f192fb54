"""The signals that friction monitors read."""

from __future__ import annotations

from typing import Annotated, NamedTuple


class SteeringSample(NamedTuple):
    """Signals of one sample; NaN where one is missing."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    driver_torque: Annotated[float, "N*m"]
    motor_torque: Annotated[float, "N*m"]
    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    vehicle_speed: Annotated[float, "m/s"]
