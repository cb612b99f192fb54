"""Steering with rack and pinion as two bodies: with the motor on either of them, and that of the demonstrator."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.physics.friction import viscous
from tierod.physics.steering import column_torque_of_motor
from tierod_lab.ground.laws import lash_torque
from tierod_lab.ground.parts import Hand, Loads, Memory, Steer, signals
from tierod_lab.ground.steering import (
    Dry,
    Linkage,
    Motor,
    Rack,
    Resistance,
    Shaft,
    TorsionBar,
    Wheel,
    assist_motor,
    steering_signals,
)
from tierod_lab.ground.steering.friction import Dahl, DryFriction


@dataclass(frozen=True)
class Mesh:
    """Tooth mesh of pinion and rack, along the rack."""

    stiffness: Annotated[float, "N/m", POSITIVE] = 1e8
    damping: Annotated[float, "N*s/m", NOT_NEGATIVE] = 5e3
    # total free travel of the rack against the held pinion; a spring-loaded yoke leaves none
    play: Annotated[float, "m", NOT_NEGATIVE] = 0.0


class RackMotion(NamedTuple):
    """State of motion of a rack steering; motor torque and wheel are () if the steering has none."""

    angle: Scalar
    rate: Scalar
    position: Scalar
    speed: Scalar
    motor_torque: Tree
    wheel: Tree


class RackMemory(NamedTuple):
    """Memory of the dry friction of the gear and of the kingpins."""

    gear: Memory
    kingpins: Memory


class _Balance(NamedTuple):
    driver_torque: Scalar
    friction: Scalar
    resistance: Resistance
    acceleration: Scalar
    rack_acceleration: Scalar
    wheel_acceleration: Scalar


@dataclass(frozen=True)
class RackEps:
    """Steering wheel, torsion bar, pinion, rack with motor, and linkage; typical of a mid-size car."""

    wheel_inertia: Annotated[float, "kg*m**2", POSITIVE] = 0.035
    wheel_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.2
    pinion_inertia: Annotated[float, "kg*m**2", POSITIVE] = 4e-4
    pinion_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.1
    rack_mass: Annotated[float, "kg", POSITIVE] = 3.0
    rack_damping: Annotated[float, "N*s/m", NOT_NEGATIVE] = 1.5e3
    centring: Annotated[float, "N/m", NOT_NEGATIVE] = 0.0
    mesh: Mesh = field(default_factory=Mesh)
    friction: DryFriction = field(default_factory=DryFriction)
    # whether it acts on the rack (yoke, bushings, screw: divided by the rack ratio it is a force) or on the pinion
    friction_on_rack: bool = True
    reference_load: Annotated[float, "N*m", POSITIVE] = 4.0
    motor: Motor | None = field(default_factory=assist_motor)  # None for a rack without a motor
    motor_on_rack: bool = True  # whether the motor drives the rack by belt and ball screw; else it drives the pinion
    linkage: Linkage = field(default_factory=Linkage)
    # None for a rigid column, whose driver torque is that of the hands
    torsion_bar: TorsionBar | None = field(default_factory=TorsionBar)

    @property
    def actuators(self) -> tuple[str, ...]:
        return () if self.motor is None else ("motor_torque",)

    def init(self) -> RackMotion:
        motor = () if self.motor is None else 0.0
        return RackMotion(0.0, 0.0, 0.0, 0.0, motor, () if self.torsion_bar is None else Wheel(0.0, 0.0))

    def remembered(self) -> RackMemory:
        return RackMemory(self.friction.remembered(), self.linkage.remembered())

    def stiff(self) -> RackMotion:
        return self.init()._replace(position=-self.mesh.play)

    def sticking(self, motion: RackMotion, memory: RackMemory) -> dict[tuple[str, str], Scalar]:
        rack, (inertia, mass) = self._rack(motion), self._inertias()
        kingpins = self.linkage.stiffness(rack.angle, rack.rate, memory.kingpins)
        _, rate = self._rubbed(motion, motion)
        gear = self.friction.stiffness(memory.gear, rate, self._rubbing(motion))
        on_rack, on_pinion = (kingpins + gear, 0.0) if self.friction_on_rack else (kingpins, gear)
        ratio = self.linkage.rack_ratio
        return {("speed", "position"): -on_rack / (ratio * ratio * mass), ("rate", "angle"): -on_pinion / inertia}

    def steer(self, motion: RackMotion) -> Steer:
        ratio = self.linkage.rack_ratio
        return self.linkage.steer(motion.position / ratio, motion.speed / ratio)

    def hand(self, motion: RackMotion) -> Hand:
        return Hand(motion.angle, motion.rate) if self.torsion_bar is None else Hand(*motion.wheel)

    def derivative(self, motion: RackMotion, start: RackMotion, memory: RackMemory, loads: Loads) -> RackMotion:
        balance = self._balance(motion, start, memory, loads)
        motor, shaft = self.motor, self._shaft(motion)
        return RackMotion(
            motion.rate,
            balance.acceleration,
            motion.speed,
            balance.rack_acceleration,
            () if motor is None else motor.torque_rate(motion.motor_torque, loads.actuator_torques[0], shaft.rate),
            () if self.torsion_bar is None else Wheel(motion.wheel.rate, balance.wheel_acceleration),
        )

    def advance(self, motion: RackMotion, start: RackMotion, memory: RackMemory, loads: Loads) -> RackMemory:
        rack, before = self._rack(motion), self._rack(start)
        return RackMemory(
            self.friction.advance(memory.gear, *self._rubbed(motion, start), angle=self._rubbing(motion)),
            self.linkage.advance(rack.angle, rack.rate, before.angle, memory.kingpins, loads),
        )

    def signals(self, motion: RackMotion, memory: RackMemory, loads: Loads) -> Tree:
        balance, rack = self._balance(motion, motion, memory, loads), self._rack(motion)
        level = self.friction.sliding_level(self._rubbing(motion)) + self.linkage.friction_level(rack.angle)
        return steering_signals(
            self.linkage,
            self.hand(motion),
            balance.wheel_acceleration,
            balance.driver_torque,
            self._shaft(motion),
            motion.angle,
            rack._replace(acceleration=balance.rack_acceleration / self.linkage.rack_ratio),
            balance.resistance,
            Dry(level, balance.friction + balance.resistance.friction),
        )

    def _balance(self, motion: RackMotion, start: RackMotion, memory: RackMemory, loads: Loads) -> _Balance:
        rack, before, ratio = self._rack(motion), self._rack(start), self.linkage.rack_ratio
        resistance = self.linkage.resistance(rack.angle, rack.rate, before.angle, memory.kingpins, loads)
        load = resistance.kingpin / self.reference_load
        friction = self.friction.torque(memory.gear, *self._rubbed(motion, start), load, self._rubbing(motion))
        mesh, apart = self.mesh, (ratio * motion.angle - motion.position, ratio * motion.rate - motion.speed)
        passed = lash_torque(*apart, mesh.stiffness, mesh.damping, mesh.play)
        (at_pinion, at_rack), (inertia, mass) = self._motor(motion), self._inertias()
        if self.friction_on_rack:
            at_rack = at_rack - friction
        else:
            at_pinion = at_pinion - friction
        drive = at_pinion - viscous(motion.rate, self.pinion_damping) - ratio * passed
        push = passed + (at_rack - resistance.total) / ratio
        push = push - viscous(motion.speed, self.rack_damping) - self.centring * motion.position
        if self.torsion_bar is None:
            driver, drive = loads.hand_torque, drive - viscous(motion.rate, self.wheel_damping)
            acceleration = wheel_acceleration = (driver + drive) / inertia
        else:
            driver = self.torsion_bar.torque(motion.wheel, motion.angle, motion.rate)
            acceleration = (driver + drive) / inertia
            held = loads.hand_torque - viscous(motion.wheel.rate, self.wheel_damping)
            wheel_acceleration = (held - driver) / self.wheel_inertia
        return _Balance(driver, friction, resistance, acceleration, push / mass, wheel_acceleration)

    def _rack(self, motion: RackMotion) -> Rack:
        ratio = self.linkage.rack_ratio
        return Rack(motion.position / ratio, motion.speed / ratio, 0.0)

    def _rubbing(self, motion: RackMotion) -> Scalar:
        """Angle of the body on which the friction acts, referred to the pinion [rad]."""
        return motion.position / self.linkage.rack_ratio if self.friction_on_rack else motion.angle

    def _rubbed(self, motion: RackMotion, start: RackMotion) -> tuple[Scalar, Scalar]:
        """Angle since the start of the step [rad] and rate [rad/s] of the body on which the friction acts."""
        turned = self._rubbing(motion) - self._rubbing(start)
        return turned, motion.speed / self.linkage.rack_ratio if self.friction_on_rack else motion.rate

    def _shaft(self, motion: RackMotion) -> Shaft:
        if self.motor is None:
            return Shaft(0.0, 0.0, 0.0)
        rack = self._rack(motion)
        angle, rate = (rack.angle, rack.rate) if self.motor_on_rack else (motion.angle, motion.rate)
        return Shaft(motion.motor_torque, self.motor.ratio * angle, self.motor.ratio * rate)

    def _motor(self, motion: RackMotion) -> tuple[Scalar, Scalar]:
        """Torque of the motor on the pinion and on the rack, referred to the pinion [N*m]."""
        if self.motor is None:
            return 0.0, 0.0
        shaft, motor = self._shaft(motion), self.motor
        torque = motor.shaft_torque(shaft.torque, shaft.angle) - viscous(shaft.rate, motor.damping)
        torque = column_torque_of_motor(torque, motor.ratio)
        return (0.0, torque) if self.motor_on_rack else (torque, 0.0)

    def _inertias(self) -> tuple[Scalar, Scalar]:
        """Inertia of the parts that move with the pinion [kg*m**2], and mass of those that move with the rack [kg]."""
        inertia = self.pinion_inertia if self.torsion_bar is not None else self.pinion_inertia + self.wheel_inertia
        moved, square = self.linkage.inertia, self.linkage.rack_ratio * self.linkage.rack_ratio
        if self.motor is not None:
            rotor = self.motor.ratio * self.motor.ratio * self.motor.inertia
            inertia, moved = (inertia, moved + rotor) if self.motor_on_rack else (inertia + rotor, moved)
        return inertia, self.rack_mass + moved / square


def demonstrator_rack() -> RackEps:
    """Rack and pinion of the demonstrator of Li, Frey and Gauterin, without the motors on its column.

    Source: Table A1 of the paper, without steering wheel and torsion bar. The inertia is printed as 45 kg*m**2 and
    taken as 0.045, divided between `wheel_inertia` and `pinion_inertia`, of which only the sum matters. The ratio is
    printed as the reciprocal of that which eqs (1) to (5) require. The build-up angle of friction is assumed.
    """
    return RackEps(
        wheel_inertia=0.040,
        wheel_damping=0.0,
        pinion_inertia=0.005,
        pinion_damping=0.0,
        rack_mass=3.0,
        rack_damping=22867.0,
        centring=31227.0,
        mesh=Mesh(1e8, 1e3),
        friction=DryFriction(level=1.11, law=Dahl(math.radians(1.0))),
        friction_on_rack=False,
        motor=None,
        linkage=Linkage(
            ratio=1.0 / 19.7,
            ackermann_gain=0.0,
            rack_ratio=1.0 / 146.12,
            road_wheel_inertia=0.0,
            friction=DryFriction(level=0.0),
        ),
        torsion_bar=None,
    )


class DemonstratorMotion(NamedTuple):
    """Motion of column and rack, and the torques of both motors at their shafts [N*m]."""

    rack: RackMotion
    torque_1: Scalar
    torque_2: Scalar


DemonstratorSignals = signals(
    "DemonstratorSignals",
    """steering_wheel_angle steering_wheel_rate steering_shaft_torque tie_rod_force tie_rod_force_left
    tie_rod_force_right steering_motor_1_torque steering_motor_2_torque drive_torque_left drive_torque_right
    rack_position rack_speed road_wheel_angle_left road_wheel_angle_right
    truth_steering_wheel_acceleration[rad/s**2] truth_friction_torque[N*m] truth_friction_resistance[N*m]""",
)
"""Signals before sensors, and quantities without a sensor; the steering-wheel angle is that of the column.

The drive torques are those of the previous step. Friction is defined as in `SteeringSignals`.
"""


def steering_motor() -> Motor:
    """One motor of the demonstrator, directly on the column; assumed values."""
    return Motor(ratio=1.0, inertia=2.5e-3, damping=0.0, lag=3e-3, maximum_torque=15.0)


@dataclass(frozen=True)
class Demonstrator:
    """Column with two redundant motors, rack and pinion.

    The inertia of the motors is part of the rack's `wheel_inertia`; the shaft torque sensor is below the motors.
    Source: Li, Frey, Gauterin, eq (2); the connection force is multiplied by the rack ratio in the first row (printed
    without).
    """

    rack: RackEps = field(default_factory=demonstrator_rack)
    steering_motor_1: Motor = field(default_factory=steering_motor)
    steering_motor_2: Motor = field(default_factory=steering_motor)

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("steering_motor_1_torque", "steering_motor_2_torque", "drive_torque_left", "drive_torque_right")

    def init(self) -> DemonstratorMotion:
        return DemonstratorMotion(self.rack.init(), 0.0, 0.0)

    def remembered(self) -> RackMemory:
        return self.rack.remembered()

    def stiff(self) -> DemonstratorMotion:
        return DemonstratorMotion(self.rack.stiff(), 0.0, 0.0)

    def sticking(self, motion: DemonstratorMotion, memory: RackMemory) -> dict[tuple[str, str], Scalar]:
        entries = self.rack.sticking(motion.rack, memory)
        return {(f"rack.{rate}", f"rack.{angle}"): entry for (rate, angle), entry in entries.items()}

    def steer(self, motion: DemonstratorMotion) -> Steer:
        return self.rack.steer(motion.rack)

    def hand(self, motion: DemonstratorMotion) -> Hand:
        return self.rack.hand(motion.rack)

    def derivative(
        self, motion: DemonstratorMotion, start: DemonstratorMotion, memory: RackMemory, loads: Loads
    ) -> DemonstratorMotion:
        return DemonstratorMotion(
            self.rack.derivative(motion.rack, start.rack, memory, self._on_rack(motion, loads)),
            self.steering_motor_1.torque_rate(motion.torque_1, loads.actuator_torques[0]),
            self.steering_motor_2.torque_rate(motion.torque_2, loads.actuator_torques[1]),
        )

    def advance(
        self, motion: DemonstratorMotion, start: DemonstratorMotion, memory: RackMemory, loads: Loads
    ) -> RackMemory:
        return self.rack.advance(motion.rack, start.rack, memory, self._on_rack(motion, loads))

    def signals(self, motion: DemonstratorMotion, memory: RackMemory, loads: Loads) -> Tree:
        seen = self.rack.signals(motion.rack, memory, self._on_rack(motion, loads))
        acceleration = seen.truth_steering_wheel_acceleration
        motors = (self.steering_motor_1, self.steering_motor_2)
        # The rack computes the torque above the motors, the sensor is below them: their rotors' inertia is subtracted.
        above = sum(motor.ratio * motor.ratio * motor.inertia for motor in motors)
        return DemonstratorSignals(
            seen.steering_wheel_angle,
            seen.steering_wheel_rate,
            seen.driver_torque - above * acceleration,
            seen.tie_rod_force_left + seen.tie_rod_force_right,
            seen.tie_rod_force_left,
            seen.tie_rod_force_right,
            motion.torque_1,
            motion.torque_2,
            loads.actuator_torques[2],
            loads.actuator_torques[3],
            seen.rack_position,
            seen.rack_speed,
            seen.road_wheel_angle_left,
            seen.road_wheel_angle_right,
            acceleration,
            seen.truth_friction_torque,
            seen.truth_friction_resistance,
        )

    def _on_rack(self, motion: DemonstratorMotion, loads: Loads) -> Loads:
        first = column_torque_of_motor(motion.torque_1, self.steering_motor_1.ratio)
        second = column_torque_of_motor(motion.torque_2, self.steering_motor_2.ratio)
        return loads._replace(hand_torque=loads.hand_torque + first + second, actuator_torques=())
