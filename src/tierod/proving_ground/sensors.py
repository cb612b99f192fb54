"""Sensors of the virtual car: gain, bias, noise, quantisation, delay and rate of each channel."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from tierod.errors import ParameterError


@dataclass(frozen=True)
class Sensor:
    """One sensor: measured = rounded(gain * truth + bias + noise).

    Args:
        noise: standard deviation of white noise, in the unit of the signal
        bias: constant offset, in the unit of the signal
        gain: scale; 1 is right
        quantum: step of the reading, in the unit of the signal; 0 is continuous
        delay: age of the value that is read
        rate: readings per second; a divisor of the plant's rate
    """

    noise: float = 0.0
    bias: float = 0.0
    gain: float = 1.0
    quantum: float = 0.0
    delay: Annotated[float, "s"] = 0.0
    rate: Annotated[float, "Hz"] = 100.0

    def __post_init__(self):
        if not (self.rate > 0.0 and self.noise >= 0.0 and self.quantum >= 0.0 and self.delay >= 0.0):
            raise ParameterError(
                f"a sensor needs a positive rate, and noise, quantum and delay that are not negative; given: {self}"
            )

    def measure(self, truth: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        """Readings of a true signal that was sampled at the sensor's rate, in the signal's unit, shape (n,)."""
        if self.delay > 0.0:
            index = np.arange(len(truth))
            truth = np.interp(index - self.delay * self.rate, index, truth)
        reading = self.gain * truth + self.bias + self.noise * generator.standard_normal(len(truth))
        return reading if self.quantum == 0.0 else np.round(reading / self.quantum) * self.quantum


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
