"""Cars with electric power steering, steer-by-wire, active front steering, and the automated demonstrator."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import POSITIVE
from tierod.physics.steering import superposed_target
from tierod_lab.ground.cars import Car, Controlled, Observed, Read, Torques
from tierod_lab.ground.chassis import demonstrator
from tierod_lab.ground.control import AngleControl, AngleMemory, AssistMemory, AssistUnit, Feel, VariableRatio
from tierod_lab.ground.drivers import AutomatedDriver, Command, Sensed
from tierod_lab.ground.motor import AFS_MOTOR, EPS_MOTOR, IN_LOOP, DriveSignals, DriveState, PmMotor, Rotor, Senses
from tierod_lab.ground.parts import Chassis, Intent, Memory, Reaction, Steering, Wheels, signals
from tierod_lab.ground.powertrain import WheelMotors
from tierod_lab.ground.steering import Motor
from tierod_lab.ground.steering.column_eps import ActiveFront, ColumnEps
from tierod_lab.ground.steering.rack_eps import Demonstrator
from tierod_lab.ground.steering.steer_by_wire import SteerByWire

MOTION = ("steering_wheel_angle", "steering_wheel_rate", "vehicle_speed")  # Signals that most control units read
Assisted = signals("Assisted", "motor_target_torque")
Steered = signals("Steered", "target_road_wheel_angle[rad] motor_target_torque")


@dataclass(frozen=True)
class EpsCar(Car):
    """Chassis, EPS steering, driver and assist unit; the steering is a `ColumnEps` or a `RackEps`."""

    steering: Steering = field(default_factory=ColumnEps)
    assist: AssistUnit = field(default_factory=AssistUnit)

    @property
    def ports(self) -> tuple[str, ...]:
        return ("driver_torque", *MOTION, *self.steering.actuators)

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


AssistedByDrive = signals(
    "AssistedByDrive",
    """motor_target_torque motor_current_alpha motor_current_beta motor_voltage_alpha motor_voltage_beta
    motor_target_voltage_alpha motor_target_voltage_beta motor_temperature supply_voltage supply_current
    truth_motor_resistance[ohm] truth_motor_flux[V*s]""",
)
"""Signals of assist unit and drive; torque, angle and speed of the motor shaft are signals of the steering."""


class DriveUnits(NamedTuple):
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

    def reset(self) -> DriveUnits:
        return DriveUnits(super().reset(), self.motor.init())

    def control(self, memory: DriveUnits, seen: Observed, read: Read) -> Controlled:
        assist, (request,), _ = super().control(memory.assist, seen, read)
        motor, signals, torque = self.motor.torque(
            memory.motor,
            Rotor(seen.steering.motor_angle_mechanical, seen.steering.motor_speed),
            read("motor_torque", request),
            self.step_time,
            Senses.through(read),
        )
        _, _, temperature, *supply, _, _, resistance, flux = signals
        shown = AssistedByDrive(request, *signals.fine[:6], temperature, *supply, resistance, flux)
        return DriveUnits(assist, motor), (torque,), shown


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
        return (*MOTION, "road_wheel_angle", *self.steering.actuators)

    def reset(self) -> AngleMemory:
        return self.angle_control.remembered()

    def control(self, memory: AngleMemory, seen: Observed, read: Read) -> Controlled:
        wheel = read("steering_wheel_angle", seen.hand.angle)
        gain = self.gain.gain(read("vehicle_speed", seen.vehicle_speed))
        target = self.steering_ratio * gain * wheel
        sensed = read("road_wheel_angle", seen.steering.road_wheel_angle)
        memory, torque = self.angle_control.decide(memory, target, sensed)
        feedback = self.feel.torque(wheel, read("steering_wheel_rate", seen.hand.rate), seen.steering.motor_torque)
        return memory, (torque, feedback), Steered(target, torque)


class Superposing(NamedTuple):
    """Signals of the control units, and of the motor at its own sampling rate."""

    target_motor_angle_mechanical: Annotated[Scalar, "rad"]
    motor_target_torque: Annotated[Scalar, "N*m"]
    motor: DriveSignals


class SuperpositionUnits(NamedTuple):
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
        return ("driver_torque", *MOTION, *IN_LOOP, *self.actuators, "motor_lock")

    def reset(self) -> SuperpositionUnits:
        return SuperpositionUnits(self.assist.remembered(), self.angle_control.remembered(), self.motor.init())

    def control(self, memory: SuperpositionUnits, seen: Observed, read: Read) -> Controlled:
        steering, before = seen.steering, memory.motor.rotor
        speed, wheel = read("vehicle_speed", seen.vehicle_speed), read("steering_wheel_angle", seen.hand.angle)
        driver, rate = read("driver_torque", steering.driver_torque), read("steering_wheel_rate", seen.hand.rate)
        assist, assist_torque = self.assist.decide(memory.assist, driver, speed, wheel, rate)
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
        units = SuperpositionUnits(assist, angle, motor)
        return units, (assist_torque, mean_speed), Superposing(target, torque, signals)


Commanded = signals(
    "Commanded",
    """target_steering_wheel_angle target_vehicle_speed steering_motor_1_target_torque steering_motor_2_target_torque
    target_drive_torque_left target_drive_torque_right""",
)
"""Targets set by the automated driver."""


class DemonstratorUnits(NamedTuple):
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
        wheels = ("wheel_speed_rear_left", "wheel_speed_rear_right")
        return ("steering_wheel_angle", "yaw_rate", *wheels, *self.steering.actuators)

    def reset(self) -> DemonstratorUnits:
        return DemonstratorUnits(self.driver.reset(), 0.0, 0.0)

    def control(self, memory: DemonstratorUnits, seen: Observed, read: Read) -> Controlled:
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
        units = DemonstratorUnits(command, *self.powertrain.lagging(memory.left, memory.right, asked, self.step_time))
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
