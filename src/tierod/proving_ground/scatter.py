"""Scatter from drive to drive: no two cars, and no two sensors, are alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tierod.proving_ground.car import EpsCar
from tierod.proving_ground.sensors import SensorNoise


@dataclass(frozen=True)
class Scatter:
    """Standard deviations of what differs from drive to drive; gains and parameters are log-normal.

    The defaults are those of the scatter study behind the friction monitor. `mass`, `tyre_stiffness` and `torque_delay`
    belong to its second, harder form and are off by default.
    """

    torque_gain: Annotated[float, ""] = 0.10
    damping: Annotated[float, ""] = 0.4
    inertia: Annotated[float, ""] = 0.3
    trail: Annotated[float, ""] = 0.3
    driver_torque_offset: Annotated[float, "N*m"] = 0.3
    lateral_acceleration_bias: Annotated[float, "m/s**2"] = 0.3
    steering_wheel_rate_noise: Annotated[float, "rad/s"] = 0.02
    tyre_stiffness: Annotated[float, ""] = 0.0
    mass: Annotated[float, ""] = 0.0
    torque_delay: Annotated[float, "s"] = 0.0

    def draw(self, car: EpsCar, noise: SensorNoise, generator: np.random.Generator) -> tuple[EpsCar, SensorNoise]:
        """A car and its sensors, drawn around the given ones.

        Args:
            car: the nominal car
            noise: the nominal sensors; the offsets drawn replace theirs
            generator: source of chance
        """

        def factor(deviation: float) -> float:
            return float(np.exp(deviation * generator.standard_normal()))

        steering = replace(
            car.steering,
            damping=car.steering.damping * factor(self.damping),
            inertia=car.steering.inertia * factor(self.inertia),
        )
        trail = factor(self.trail)
        mass = factor(self.mass)
        chassis = replace(
            car.chassis,
            mechanical_trail=car.chassis.mechanical_trail * trail,
            contact_half_length=car.chassis.contact_half_length * trail,
            front_stiffness=car.chassis.front_stiffness * factor(self.tyre_stiffness),
            rear_stiffness=car.chassis.rear_stiffness * factor(self.tyre_stiffness),
            mass=car.chassis.mass * mass,
            yaw_inertia=car.chassis.yaw_inertia * mass,
        )
        return replace(car, steering=steering, chassis=chassis), self._sensors(noise, generator, factor)

    def _sensors(
        self, noise: SensorNoise, generator: np.random.Generator, factor: Callable[[float], float]
    ) -> SensorNoise:
        return replace(
            noise,
            driver_torque=replace(
                noise.driver_torque,
                gain=noise.driver_torque.gain * factor(self.torque_gain),
                bias=self.driver_torque_offset * float(generator.standard_normal()),
                delay=self.torque_delay,
            ),
            motor_torque=replace(
                noise.motor_torque,
                gain=noise.motor_torque.gain * factor(self.torque_gain),
                delay=self.torque_delay,
            ),
            lateral_acceleration=replace(
                noise.lateral_acceleration,
                bias=self.lateral_acceleration_bias * float(generator.standard_normal()),
            ),
            steering_wheel_rate=replace(noise.steering_wheel_rate, noise=self.steering_wheel_rate_noise),
        )
