"""Cars with electric power steering, the virtual test vehicles of the friction and column monitors."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod_lab.ground.cars.car import Car, Controlled, Observed, Read
from tierod_lab.ground.control.assist import AssistUnit
from tierod_lab.ground.motor import EPS_MOTOR, DriveState, PmMotor, Rotor
from tierod_lab.ground.motor.pm_motor import IN_LOOP, Fine, Senses
from tierod_lab.ground.parts import Memory, Steering
from tierod_lab.ground.steering.column_eps import ColumnEps
from tierod_lab.ground.steering.shaft import Motor


class Assisted(NamedTuple):
    """Signals of the assist unit."""

    motor_target_torque: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class EpsCar(Car):
    """Chassis, EPS steering, driver and assist unit; the steering is a `ColumnEps` or a `RackEps`."""

    steering: Steering = field(default_factory=ColumnEps)
    assist: AssistUnit = field(default_factory=AssistUnit)

    @property
    def ports(self) -> tuple[str, ...]:
        return (
            "driver_torque",
            "steering_wheel_angle",
            "steering_wheel_rate",
            "vehicle_speed",
            *self.steering.actuators,
        )

    def reset(self) -> Memory:
        return self.assist.remembered()

    def control(self, memory: Memory, seen: Observed, read: Read) -> Controlled:
        memory, torque = self.assist.decide(
            memory,
            read("driver_torque", seen.steering.driver_torque),
            read("vehicle_speed", seen.vehicle_speed),
            read("steering_wheel_angle", seen.hand.angle),
            read("steering_wheel_rate", seen.hand.rate),
        )
        return memory, (torque,), Assisted(torque)


class AssistedByDrive(NamedTuple):
    """Signals of assist unit and drive; torque, angle and speed of the motor shaft are signals of the steering."""

    motor_target_torque: Annotated[Scalar, "N*m"]
    motor_current_alpha: Annotated[Fine, "A"]
    motor_current_beta: Annotated[Fine, "A"]
    motor_voltage_alpha: Annotated[Fine, "V"]
    motor_voltage_beta: Annotated[Fine, "V"]
    motor_target_voltage_alpha: Annotated[Fine, "V"]
    motor_target_voltage_beta: Annotated[Fine, "V"]
    motor_temperature: Annotated[Scalar, "K"]
    supply_voltage: Annotated[Scalar, "V"]
    supply_current: Annotated[Scalar, "A"]
    truth_motor_resistance: Annotated[Scalar, "ohm"]
    truth_motor_flux: Annotated[Scalar, "V*s"]


class Units(NamedTuple):
    """Memory of the assist unit, and state of the motor between two steps."""

    assist: Memory
    motor: DriveState


def steering_for_drive() -> ColumnEps:
    """Column whose motor adds almost no lag, since the drive simulates that of the currents."""
    return ColumnEps(motor=replace(Motor(), lag=2e-4))


@dataclass(frozen=True)
class PmEpsCar(EpsCar):
    """An `EpsCar` whose assist motor has a simulated drive; the rotor is part of the steering."""

    steering: Steering = field(default_factory=steering_for_drive)
    # motor with inverter, current control and heating; rotor inertia and friction are those of the steering's motor
    motor: PmMotor = field(default_factory=lambda: EPS_MOTOR)

    @property
    def ports(self) -> tuple[str, ...]:
        return (*super().ports, *IN_LOOP)

    def reset(self) -> Units:
        return Units(super().reset(), self.motor.init())

    def control(self, memory: Units, seen: Observed, read: Read) -> Controlled:
        assist, (request,), _ = super().control(memory.assist, seen, read)
        motor, signals, torque = self.motor.torque(
            memory.motor,
            Rotor(seen.steering.motor_angle_mechanical, seen.steering.motor_speed),
            read("motor_torque", request),
            self.step_time,
            Senses.through(read),
        )
        shown = AssistedByDrive(
            request,
            *signals.fine[:6],
            signals.motor_temperature,
            signals.supply_voltage,
            signals.supply_current,
            signals.truth_motor_resistance,
            signals.truth_motor_flux,
        )
        return Units(assist, motor), (torque,), shown
