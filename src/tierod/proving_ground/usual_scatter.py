"""What usually differs from drive to drive, by names that hold for every car."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.fields import NOT_NEGATIVE, Number, check_ranges

SENSORS = "sensors."
"""Beginning of the paths that lead to sensors: "sensors.yaw_rate.bias"."""

DAMPING = ("damping", "pinion_damping", "rack_damping", "motor.damping")
INERTIA = (
    *("inertia", "wheel_inertia", "column_inertia", "pinion_inertia", "rack_mass", "motor.inertia"),
    *("steering_motor_1.inertia", "steering_motor_2.inertia"),
)
WITHIN = ("", "column.", "rack.")
"""Parts of a steering that are steerings themselves."""
TRAIL = ("mechanical_trail", "contact_half_length", "kingpins.mechanical_trail", "front.tyre.trail")
FRONT_TYRES = ("front_stiffness", "front.tyre.cornering_stiffness")
REAR_TYRES = ("rear_stiffness", "rear.tyre.cornering_stiffness")
MASS = ("mass", "yaw_inertia")


@dataclass(frozen=True)
class UsualScatter:
    """Standard deviations of what differs from drive to drive; gains and parameters are log-normal.

    The defaults are those of the scatter study behind the friction monitor. `mass`, `tyre_stiffness` and `torque_delay`
    belong to its second, harder form and are off by default. What a car does not have is left alone.

    Args:
        torque_gain: of the sensors of driver and motor torque, each by itself
        damping: of the steering below its wheel, all of it together
        inertia: of the steering, all of it together
        trail: mechanical and pneumatic, together
        driver_torque_offset: bias of its sensor, in place of the nominal one
        lateral_acceleration_bias: bias of its sensor, in place of the nominal one
        steering_wheel_rate_noise: of its sensor, not drawn
        tyre_stiffness: of each axle by itself
        mass: of the body, and its yaw inertia in the same ratio
        torque_delay: of the sensors of driver and motor torque, not drawn
    """

    torque_gain: Annotated[float, "", NOT_NEGATIVE] = 0.10
    damping: Annotated[float, "", NOT_NEGATIVE] = 0.4
    inertia: Annotated[float, "", NOT_NEGATIVE] = 0.3
    trail: Annotated[float, "", NOT_NEGATIVE] = 0.3
    driver_torque_offset: Annotated[float, "N*m", NOT_NEGATIVE] = 0.3
    lateral_acceleration_bias: Annotated[float, "m/s**2", NOT_NEGATIVE] = 0.3
    steering_wheel_rate_noise: Annotated[float, "rad/s", NOT_NEGATIVE] = 0.02
    tyre_stiffness: Annotated[float, "", NOT_NEGATIVE] = 0.0
    mass: Annotated[float, "", NOT_NEGATIVE] = 0.0
    torque_delay: Annotated[float, "s", NOT_NEGATIVE] = 0.0

    def __post_init__(self):
        check_ranges(self)

    def usual(self, known: Mapping[str, Number], generator: np.random.Generator) -> Iterator[tuple[str, float]]:
        """(path, value) of what the fields name; always with as many draws, so that one does not move another.

        Args:
            known: what can be drawn, by path
            generator: source of chance
        """

        def factor(deviation: float) -> float:
            return float(np.exp(deviation * generator.standard_normal()))

        for part, names, deviation in (
            ("steering", DAMPING, self.damping),
            ("steering", INERTIA, self.inertia),
            ("chassis", TRAIL, self.trail),
            ("chassis", MASS, self.mass),
            ("chassis", FRONT_TYRES, self.tyre_stiffness),
            ("chassis", REAR_TYRES, self.tyre_stiffness),
        ):
            drawn = factor(deviation)
            for path in (f"{part}.{within}{name}" for name in names for within in WITHIN):
                if path in known:
                    yield path, known[path].value * drawn
        sensors = {
            "driver_torque.gain": factor(self.torque_gain),
            "driver_torque.bias": self.driver_torque_offset * float(generator.standard_normal()),
            "driver_torque.delay": self.torque_delay,
            "motor_torque.gain": factor(self.torque_gain),
            "motor_torque.delay": self.torque_delay,
            "lateral_acceleration.bias": self.lateral_acceleration_bias * float(generator.standard_normal()),
            "steering_wheel_rate.noise": self.steering_wheel_rate_noise,
        }
        for name, value in sensors.items():
            path = f"{SENSORS}{name}"
            if path in known:
                yield path, value * known[path].value if name.endswith(".gain") else value
