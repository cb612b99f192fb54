"""Car with active front steering, whose motor currents are simulated at 10 kHz."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.physics.gear import superposed_target
from tierod_lab.ground.cars.car import Car, Controlled, Observed, Read
from tierod_lab.ground.control.angle_control import AngleControl, AngleMemory, VariableRatio
from tierod_lab.ground.control.assist import AssistMemory, AssistUnit
from tierod_lab.ground.motor import AFS_MOTOR, DriveState, PmMotor
from tierod_lab.ground.motor.pm_motor import IN_LOOP, DriveSignals, Senses
from tierod_lab.ground.steering.active_front import ActiveFront


class Superposing(NamedTuple):
    """Signals of the control units, and of the motor at its own sampling rate."""

    target_motor_angle_mechanical: Annotated[Scalar, "rad"]
    motor_target_torque: Annotated[Scalar, "N*m"]
    motor: DriveSignals


class Units(NamedTuple):
    """Memories of assist unit and angle control, and state of the motor between two steps."""

    assist: AssistMemory
    angle: AngleMemory
    motor: DriveState


@dataclass(frozen=True)
class ActiveFrontCar(Car):
    """Chassis, active front steering, driver, and the control units of superposition and assist."""

    steering: ActiveFront = field(default_factory=ActiveFront)
    motor: PmMotor = field(default_factory=lambda: AFS_MOTOR)
    ratio: VariableRatio = field(default_factory=VariableRatio)
    angle_control: AngleControl = field(
        default_factory=lambda: AngleControl(stiffness=3.0, damping=0.03, integral=30.0, torque_limit=3.0)
    )
    assist: AssistUnit = field(default_factory=lambda: AssistUnit(motor_ratio=1.0))

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("column_assist_torque", "motor_torque")

    @property
    def ports(self) -> tuple[str, ...]:
        return (
            "driver_torque",
            "steering_wheel_angle",
            "steering_wheel_rate",
            "vehicle_speed",
            *IN_LOOP,
            "column_assist_torque",
            "motor_torque",
            "motor_lock",
        )

    def reset(self) -> Units:
        return Units(self.assist.remembered(), self.angle_control.remembered(), self.motor.init())

    def control(self, memory: Units, seen: Observed, read: Read) -> Controlled:
        steering, before = seen.steering, memory.motor.rotor
        speed, wheel = read("vehicle_speed", seen.vehicle_speed), read("steering_wheel_angle", seen.hand.angle)
        assist, assist_torque = self.assist.decide(
            memory.assist,
            read("driver_torque", steering.driver_torque),
            speed,
            wheel,
            read("steering_wheel_rate", seen.hand.rate),
        )
        ratios = self.steering.motor_ratio, self.steering.input_ratio
        target = superposed_target(wheel, self.ratio.gain(speed), *ratios)
        sensed = read("motor_angle_mechanical", before.angle)
        angle, torque = self.angle_control.decide(memory.angle, target, sensed)
        motor, signals = self.motor.turn(
            memory.motor,
            read("motor_torque", torque),
            self.step_time,
            lambda *now: self.steering.motor_load(steering, *now),
            Senses.through(read),
            read("motor_lock", 0.0),
        )
        # With the mean speed over the step the steering reaches exactly the rotor's angle at its end.
        mean_speed = (motor.rotor.angle - before.angle) / self.step_time
        return Units(assist, angle, motor), (assist_torque, mean_speed), Superposing(target, torque, signals)
