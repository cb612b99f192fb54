"""Enabling condition of the friction monitors: samples that hold information about friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of


class GateConditions(NamedTuple):
    """The conditions of the gate one by one, so that a verdict can name the one that kept it closed.

    Args:
        hands_on: the driver's torque is large enough
        same_direction: driver and motor pull the same way
        moving: the steering wheel turns fast enough for friction to have a direction
        not_too_fast: and slowly enough to be followed
        rolling: the vehicle is fast enough; the Python value True where speed is not looked at
    """

    hands_on: Scalar
    same_direction: Scalar
    moving: Scalar
    not_too_fast: Scalar
    rolling: Scalar


@dataclass(frozen=True)
class FrictionGate:
    """Open while the steering is worked by driver and motor alike and moves neither too slowly nor too fast.

    A low minimum_rate lets noise of the rate decide the sign of friction; it must stay well above that noise: in
    simulation 0.05 rad/s costs 0.4 to 1.5 N m. Hands off, active return or lane keeping break the second
    condition: the gate then indicates little.

    Args:
        minimum_driver_torque: 0.5 N m as printed: the assist is then active [N m]
        minimum_rate: 0.05 rad/s as printed: friction has a direction [rad/s]
        maximum_rate: 1 rad/s as printed (scan: "0.1rads"): the filter can follow [rad/s]
        minimum_speed: of the vehicle [m/s]; None leaves it out, as printed. About 3: below it tyre scrub is no
            self-aligning torque

    Source: Mohtat et al., eq (14).
    """

    minimum_driver_torque: Annotated[float, "N*m"] = 0.5
    minimum_rate: Annotated[float, "rad/s"] = 0.05
    maximum_rate: Annotated[float, "rad/s"] = 1.0
    minimum_speed: Annotated[float, "m/s"] | None = None

    def opened(
        self, driver_torque: Scalar, motor_torque: Scalar, steering_wheel_rate: Scalar, vehicle_speed: Scalar = 0.0
    ) -> Scalar:
        """Whether the sample enables the estimate of friction; a missing signal closes the gate.

        Args:
            driver_torque: at the steering wheel [N m]
            motor_torque: at the motor shaft, same sign convention [N m]
            steering_wheel_rate: [rad/s]
            vehicle_speed: [m/s]; unused where minimum_speed is None
        """
        *worked, rolling = self.conditions(driver_torque, motor_torque, steering_wheel_rate, vehicle_speed)
        return all_of(*worked) if rolling is True else all_of(*worked, rolling)

    def conditions(
        self, driver_torque: Scalar, motor_torque: Scalar, steering_wheel_rate: Scalar, vehicle_speed: Scalar = 0.0
    ) -> GateConditions:
        """Each condition of `opened`, with the same arguments."""
        rate = absolute(steering_wheel_rate)
        return GateConditions(
            hands_on=absolute(driver_torque) > self.minimum_driver_torque,
            same_direction=driver_torque * motor_torque > 0.0,
            moving=self.minimum_rate < rate,
            not_too_fast=rate < self.maximum_rate,
            rolling=True if self.minimum_speed is None else vehicle_speed > self.minimum_speed,
        )
