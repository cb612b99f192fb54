"""The seven channels of the friction monitor's design as a dataclass."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field

from tierod.proving_ground.sensors.sensor import Sensor


@dataclass(frozen=True)
class SensorNoise:
    """The sensors of a production car, one per canonical channel.

    Noise and offsets of rate, yaw, acceleration and torques are those of the simulations this monitor was designed on;
    the angle's step of 0.1 degrees is usual on CAN.
    """

    steering_wheel_angle: Sensor = field(default_factory=lambda: Sensor(quantum=math.radians(0.1)))
    steering_wheel_rate: Sensor = field(default_factory=lambda: Sensor(noise=0.01))
    driver_torque: Sensor = field(default_factory=lambda: Sensor(noise=0.05, bias=0.05))
    motor_torque: Sensor = field(default_factory=lambda: Sensor(noise=0.005))
    yaw_rate: Sensor = field(default_factory=lambda: Sensor(noise=3e-3, bias=2e-3))
    lateral_acceleration: Sensor = field(default_factory=lambda: Sensor(noise=0.1, bias=0.08))
    vehicle_speed: Sensor = field(default_factory=lambda: Sensor(noise=0.02))

    @classmethod
    def ideal(cls, rate: float = 100.0) -> SensorNoise:
        """Sensors that read the truth, at this rate [Hz]."""
        return cls(*[Sensor(rate=rate) for _ in dataclasses.fields(cls)])

    def items(self) -> list[tuple[str, Sensor]]:
        """(channel, sensor) of every channel, in order."""
        return [(f.name, getattr(self, f.name)) for f in dataclasses.fields(self)]
