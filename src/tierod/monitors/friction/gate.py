"""Enabling condition of the friction monitors, which selects samples with information about friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of


class GateConditions(NamedTuple):
    """Conditions of the gate one by one, so that a verdict can name the one that kept it closed.

    Args:
        hands_on: the driver's torque is large enough
        same_direction: driver and motor pull the same way
        moving: the steering wheel turns fast enough for friction to have a direction
        not_too_fast: the steering wheel turns slowly enough for the filter to follow
        rolling: the vehicle is fast enough; the Python value True where no minimum speed is set
    """

    hands_on: Scalar
    same_direction: Scalar
    moving: Scalar
    not_too_fast: Scalar
    rolling: Scalar


@dataclass(frozen=True)
class FrictionGate:
    """Gate that opens while driver and motor steer in the same direction, neither too slowly nor too fast.

    `minimum_rate` must stay well above the noise of the rate, or noise decides the sign of friction: in simulation a
    noise of 0.05 rad/s costs 0.4 to 1.5 N m. Hands off, active return and lane keeping break the condition on the signs
    of the torques; the gate then indicates little.

    Args:
        minimum_driver_torque: driver's torque above which the assist is active [N m]; 0.5 as printed
        minimum_rate: rate above which friction has a direction [rad/s]; 0.05 as printed
        maximum_rate: rate up to which the filter can follow [rad/s]; 1 as printed (scan: "0.1rads")
        minimum_speed: lowest speed of the vehicle [m/s]; None leaves the condition out, as printed. About 3: below it
            tyre scrub is not a self-aligning torque

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
            driver_torque: torque at the steering wheel [N m]
            motor_torque: torque at the motor shaft, same sign convention [N m]
            steering_wheel_rate: rate of the steering wheel [rad/s]
            vehicle_speed: speed of the vehicle [m/s]; unused where minimum_speed is None
        """
        *worked, rolling = self.conditions(driver_torque, motor_torque, steering_wheel_rate, vehicle_speed)
        return all_of(*worked) if rolling is True else all_of(*worked, rolling)

    def conditions(
        self, driver_torque: Scalar, motor_torque: Scalar, steering_wheel_rate: Scalar, vehicle_speed: Scalar = 0.0
    ) -> GateConditions:
        """The conditions of `opened` one by one, for the same arguments."""
        rate = absolute(steering_wheel_rate)
        return GateConditions(
            hands_on=absolute(driver_torque) > self.minimum_driver_torque,
            same_direction=driver_torque * motor_torque > 0.0,
            moving=self.minimum_rate < rate,
            not_too_fast=rate < self.maximum_rate,
            rolling=True if self.minimum_speed is None else vehicle_speed > self.minimum_speed,
        )
