"""When a sample tells something about friction: the enabling condition of the friction monitors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tierod.graph.maths import absolute, all_of


@dataclass(frozen=True)
class FrictionGate:
    """Open while the steering is worked by driver and motor alike and moves neither too slowly nor too fast.

    A low minimum_rate lets noise of the rate decide the sign of friction; it must stay well above that noise (errata:
    noise of 0.05 rad/s costs 0.4 to 1.5 N m of bias). Hands off, active return or lane keeping break the second
    condition: the gate then says little.

    Args:
        minimum_driver_torque: 0.5 N m as printed: the assist is then active [N m]
        minimum_rate: 0.05 rad/s as printed: friction has a direction [rad/s]
        maximum_rate: 1 rad/s as printed (scan: "0.1rads"): the filter can follow [rad/s]
        minimum_speed: of the vehicle [m/s]; None leaves it out, as printed. About 3: below it tyre scrub is no
            self-aligning torque

    Source: Mohtat et al., eq (14).
    """

    minimum_driver_torque: float = 0.5
    minimum_rate: float = 0.05
    maximum_rate: float = 1.0
    minimum_speed: float | None = None

    def opened(self, driver_torque: Any, motor_torque: Any, steering_wheel_rate: Any, vehicle_speed: Any = None) -> Any:
        """Whether the sample enables the estimate of friction; a missing signal closes the gate.

        Args:
            driver_torque: at the steering wheel [N m]
            motor_torque: at the motor shaft, same sign convention [N m]
            steering_wheel_rate: [rad/s]
            vehicle_speed: [m/s]; unused where minimum_speed is None
        """
        rate = absolute(steering_wheel_rate)
        worked = all_of(
            absolute(driver_torque) > self.minimum_driver_torque,
            driver_torque * motor_torque > 0.0,
            self.minimum_rate < rate,
            rate < self.maximum_rate,
        )
        return worked if self.minimum_speed is None else all_of(worked, vehicle_speed > self.minimum_speed)
