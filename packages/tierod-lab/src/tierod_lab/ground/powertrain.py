"""Powertrain and brakes: wheel torques for the force that the driver requests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE
from tierod.core.graph.maths import absolute, limit, maximum, minimum
from tierod.physics.friction import share_reached
from tierod_lab.ground.parts import Reaction, Wheels

CRAWL = 1.0  # Speed below which the power limit uses this speed instead of the true one [m/s]

LIMITER = 0.05  # Width of the engine speed limiter's ramp as a share of the maximum speed [-]


def _divided(torque: Scalar, front_share: Scalar) -> Wheels:
    front, rear = front_share * torque, (1.0 - front_share) * torque
    return Wheels(front, front, rear, rear)


@dataclass(frozen=True)
class Powertrain:
    """One engine, open differentials and brakes; without lag, since drivers are slower."""

    # share of the drive force at the front axle; 1 is front-wheel, 0 rear-wheel drive
    front_share: Annotated[float, "", SHARE] = 1.0
    front_brake_share: Annotated[float, "", SHARE] = 0.68
    wheel_radius: Annotated[float, "m", POSITIVE] = 0.31
    greatest_drive_force: Annotated[float, "N", NOT_NEGATIVE] = 7000.0
    greatest_power: Annotated[float, "W", NOT_NEGATIVE] = 110e3
    greatest_speed: Annotated[float, "m/s", POSITIVE] = 70.0
    greatest_brake_force: Annotated[float, "N", NOT_NEGATIVE] = 18e3

    def torques(self, force: Scalar, reaction: Reaction) -> tuple[Wheels, Wheels]:
        """Drive torque and maximum brake torque of every wheel [N*m] for a force [N], negative to brake."""
        wheels = reaction.wheel_speeds
        of_front, of_rear = 0.5 * self.front_share, 0.5 * (1.0 - self.front_share)
        turning = of_front * (wheels.front_left + wheels.front_right) + of_rear * (wheels.rear_left + wheels.rear_right)
        available = minimum(self.greatest_drive_force, self.greatest_power / maximum(absolute(turning), CRAWL))
        available = available * limit((1.0 - turning / self.greatest_speed) / LIMITER, 0.0, 1.0)
        drive = 0.5 * self.wheel_radius * limit(force, 0.0, available)
        brake = 0.5 * self.wheel_radius * limit(-force, 0.0, self.greatest_brake_force)
        return _divided(drive, self.front_share), _divided(brake, self.front_brake_share)


@dataclass(frozen=True)
class WheelMotors:
    """One electric motor in each front wheel, which drives and brakes, and friction brakes for the remaining force.

    The defaults are assumed for the light demonstrator: a few kilowatts per wheel.
    """

    wheel_radius: Annotated[float, "m", POSITIVE] = 0.243
    greatest_torque: Annotated[float, "N*m", NOT_NEGATIVE] = 160.0
    greatest_power: Annotated[float, "W", NOT_NEGATIVE] = 6e3
    front_brake_share: Annotated[float, "", SHARE] = 0.65
    greatest_brake_force: Annotated[float, "N", NOT_NEGATIVE] = 4e3
    left_lag: Annotated[float, "s", POSITIVE] = 0.01
    right_lag: Annotated[float, "s", POSITIVE] = 0.01

    def requests(self, force: Scalar, difference: Scalar, reaction: Reaction) -> tuple[Scalar, Scalar]:
        """Requested torques of the left and the right motor, within their limits [N*m].

        Args:
            force: requested force along the road, negative to brake [N]
            difference: torque of the right motor minus that of the left one, positive steers to the left [N*m]
        """
        mean = 0.5 * self.wheel_radius * force
        turning = maximum(absolute(reaction.speed), CRAWL) / self.wheel_radius
        bound = minimum(self.greatest_torque, self.greatest_power / turning)
        return limit(mean - 0.5 * difference, -bound, bound), limit(mean + 0.5 * difference, -bound, bound)

    def lagging(self, left: Scalar, right: Scalar, requests: tuple[Scalar, Scalar], step: Scalar) -> list[Scalar]:
        """Torques of the left and the right motor [N*m] after one step [s] of their first-order lags."""
        motors = ((left, requests[0], self.left_lag), (right, requests[1], self.right_lag))
        return [torque + share_reached(step / lag) * (wanted - torque) for torque, wanted, lag in motors]

    def wheels(self, left: Scalar, right: Scalar, force: Scalar) -> tuple[Wheels, Wheels]:
        """Drive torque and maximum brake torque of every wheel [N*m]; friction brakes supply what the motors cannot.

        Args:
            left, right: torques of the motors [N*m]
            force: requested force along the road, negative to brake [N]
        """
        lacking = limit(-force + (left + right) / self.wheel_radius, 0.0, self.greatest_brake_force)
        # The second bound keeps the brakes open while the driver does not brake, whatever the lagging motors do.
        brake = 0.5 * self.wheel_radius * minimum(lacking, maximum(-force, 0.0))
        return Wheels(left, right, 0.0, 0.0), _divided(brake, self.front_brake_share)

    def torques(self, force: Scalar, reaction: Reaction) -> tuple[Wheels, Wheels]:
        """Drive torque and maximum brake torque of every wheel [N*m] for a force [N], shared equally."""
        left, right = self.requests(force, 0.0, reaction)
        return self.wheels(left, right, force)
