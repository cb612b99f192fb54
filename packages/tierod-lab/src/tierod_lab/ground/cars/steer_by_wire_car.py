"""Car with steer-by-wire, the virtual test vehicle for the estimation of sideslip from steering torque."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import POSITIVE
from tierod_lab.ground.cars.car import Car, Controlled, Observed, Read
from tierod_lab.ground.control.angle_control import AngleControl, AngleMemory, Feel, VariableRatio
from tierod_lab.ground.steering.steer_by_wire import SteerByWire


class Steered(NamedTuple):
    """Signals of the control units."""

    target_road_wheel_angle: Annotated[Scalar, "rad"]
    motor_target_torque: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class SteerByWireCar(Car):
    """Chassis, steer-by-wire steering, driver, and control units of road wheels and steering feel.

    The angle control has the same damping as the steering (as in Yih, Ryu, Gerdes); its integral part compensates the
    rest.
    """

    steering: SteerByWire = field(default_factory=SteerByWire)
    steering_ratio: Annotated[float, "", POSITIVE] = 1.0 / 17.0
    gain: VariableRatio = field(default_factory=lambda: VariableRatio(standing=1.0, fast=1.0))
    angle_control: AngleControl = field(
        default_factory=lambda: AngleControl(
            stiffness=8.0, damping=0.1, integral=80.0, torque_limit=0.9, forward_damping=0.06
        )
    )
    feel: Feel = field(default_factory=Feel)

    @property
    def ports(self) -> tuple[str, ...]:
        return (
            "steering_wheel_angle",
            "steering_wheel_rate",
            "vehicle_speed",
            "road_wheel_angle",
            *self.steering.actuators,
        )

    def reset(self) -> AngleMemory:
        return self.angle_control.remembered()

    def control(self, memory: AngleMemory, seen: Observed, read: Read) -> Controlled:
        wheel = read("steering_wheel_angle", seen.hand.angle)
        gain = self.gain.gain(read("vehicle_speed", seen.vehicle_speed))
        target = self.steering_ratio * gain * wheel
        memory, torque = self.angle_control.decide(
            memory, target, read("road_wheel_angle", seen.steering.road_wheel_angle)
        )
        feedback = self.feel.torque(wheel, read("steering_wheel_rate", seen.hand.rate), seen.steering.motor_torque)
        return memory, (torque, feedback), Steered(target, torque)
