"""Automated demonstrator: one motor per front wheel, two steering motors, no steering wheel."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod_lab.ground.cars.car import Car, Controlled, Observed, Read, Torques
from tierod_lab.ground.chassis import demonstrator
from tierod_lab.ground.control.automated import AutomatedDriver, Command, Sensed
from tierod_lab.ground.parts import Chassis, Intent, Reaction, Wheels
from tierod_lab.ground.powertrain import WheelMotors
from tierod_lab.ground.steering.demonstrator import Demonstrator


class Commanded(NamedTuple):
    """Targets set by the automated driver."""

    target_steering_wheel_angle: Annotated[Scalar, "rad"]
    target_vehicle_speed: Annotated[Scalar, "m/s"]
    steering_motor_1_target_torque: Annotated[Scalar, "N*m"]
    steering_motor_2_target_torque: Annotated[Scalar, "N*m"]
    target_drive_torque_left: Annotated[Scalar, "N*m"]
    target_drive_torque_right: Annotated[Scalar, "N*m"]


class Units(NamedTuple):
    """Memory of the automated driver, and the torques of both wheel motors [N*m]."""

    command: Command
    left: Scalar
    right: Scalar


@dataclass(frozen=True)
class DemonstratorCar(Car):
    """Chassis, steering with two motors, motors in the front wheels, and the automated driver."""

    chassis: Chassis = field(default_factory=demonstrator)
    steering: Demonstrator = field(default_factory=Demonstrator)
    driver: AutomatedDriver = field(default_factory=AutomatedDriver)
    powertrain: WheelMotors = field(default_factory=WheelMotors)  # type: ignore[assignment]  # used by this car alone

    @property
    def ports(self) -> tuple[str, ...]:
        return (
            "steering_wheel_angle",
            "yaw_rate",
            "wheel_speed_rear_left",
            "wheel_speed_rear_right",
            *self.steering.actuators,
        )

    def reset(self) -> Units:
        return Units(self.driver.reset(), 0.0, 0.0)

    def control(self, memory: Units, seen: Observed, read: Read) -> Controlled:
        wheels = seen.reaction.wheel_speeds
        rear_left = read("wheel_speed_rear_left", wheels.rear_left)
        rear_right = read("wheel_speed_rear_right", wheels.rear_right)
        sensed = Sensed(
            0.5 * (rear_left + rear_right),
            read("yaw_rate", seen.reaction.yaw_rate),
            read("steering_wheel_angle", seen.hand.angle),
        )
        command, targets = self.driver.command(memory.command, seen.view, seen.demand, sensed)
        wanted = self.powertrain.requests(targets.force, targets.drive_difference, seen.reaction)
        asked = read("drive_torque_left", wanted[0]), read("drive_torque_right", wanted[1])
        units = Units(command, *self.powertrain.lagging(memory.left, memory.right, asked, self.step_time))
        first = targets.steering_torque_1 / self.steering.steering_motor_1.ratio
        second = targets.steering_torque_2 / self.steering.steering_motor_2.ratio
        signals = Commanded(targets.steering_wheel_angle, targets.speed, first, second, *wanted)
        return units, (first, second, units.left, units.right), signals

    def drives(self, intent: Intent, reaction: Reaction, torques: Torques) -> tuple[Wheels, Wheels]:
        """Torques of the wheel motors, which drive and brake; the friction brakes are for emergencies and stay open."""
        return self.powertrain.wheels(torques[2], torques[3], 0.0)

    def drive_force(self, intent: Intent, torques: Torques) -> Scalar:
        """Force of the wheel motors along the road [N]."""
        return (torques[2] + torques[3]) / self.powertrain.wheel_radius
