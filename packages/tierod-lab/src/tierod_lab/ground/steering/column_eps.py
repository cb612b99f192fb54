"""Electric power steering with the motor on the column."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.physics.friction import viscous
from tierod.physics.gear import lash_torque
from tierod.physics.steering_ratio import column_torque_of_motor
from tierod_lab.ground.parts import Hand, Loads, Memory, Steer
from tierod_lab.ground.steering.friction import DryFriction
from tierod_lab.ground.steering.linkage import (
    Dry,
    Linkage,
    Rack,
    Resistance,
    Shaft,
    SteeringSignals,
    steering_signals,
)
from tierod_lab.ground.steering.shaft import Motor, TorsionBar, Wheel, assist_motor


@dataclass(frozen=True)
class WormGear:
    """Elastic gear between motor and column, referred to the column.

    The stiffness is that identified by Raffone (7.26 N*m/rad at the motor, 18 to 1), the damping 10 % of critical.
    """

    stiffness: Annotated[float, "N*m/rad", POSITIVE] = 2350.0
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.7
    # total free travel of the column against the held motor; a sprung worm has none
    play: Annotated[float, "rad", NOT_NEGATIVE] = 0.0


class Rotor(NamedTuple):
    """Motion of a rotor that an elastic gear separates from the column."""

    angle: Scalar
    rate: Scalar


class ColumnMotion(NamedTuple):
    """State of motion of a column; wheel and rotor are () if they move with the column."""

    angle: Scalar
    rate: Scalar
    motor_torque: Scalar
    wheel: Tree
    rotor: Tree


class ColumnMemory(NamedTuple):
    """Memory of the dry friction of the column and of the kingpins."""

    column: Memory
    kingpins: Memory


class _Balance(NamedTuple):
    driver_torque: Scalar
    friction: Scalar
    resistance: Resistance
    acceleration: Scalar
    wheel_acceleration: Scalar
    rotor_acceleration: Scalar


@dataclass(frozen=True)
class ColumnEps:
    """Steering wheel, torsion bar, column with motor, and linkage; typical of a mid-size car."""

    wheel_inertia: Annotated[float, "kg*m**2", POSITIVE] = 0.035
    wheel_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.2
    column_inertia: Annotated[float, "kg*m**2", POSITIVE] = 0.001
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.2
    friction: DryFriction = field(default_factory=DryFriction)
    reference_load: Annotated[float, "N*m", POSITIVE] = 4.0
    motor: Motor = field(default_factory=assist_motor)
    linkage: Linkage = field(default_factory=Linkage)
    # None for a rigid column, whose driver torque is that of the hands
    torsion_bar: TorsionBar | None = field(default_factory=TorsionBar)
    worm_gear: WormGear | None = None  # None for a rigid gear between motor and column

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("motor_torque",)

    def init(self) -> ColumnMotion:
        wheel = () if self.torsion_bar is None else Wheel(0.0, 0.0)
        return ColumnMotion(0.0, 0.0, 0.0, wheel, () if self.worm_gear is None else Rotor(0.0, 0.0))

    def remembered(self) -> ColumnMemory:
        return ColumnMemory(self.friction.remembered(), self.linkage.remembered())

    def stiff(self) -> ColumnMotion:
        if self.worm_gear is None:
            return self.init()
        return self.init()._replace(rotor=Rotor(self.motor.ratio * self.worm_gear.play, 0.0))

    def sticking(self, motion: ColumnMotion, memory: ColumnMemory) -> dict[tuple[str, str], Scalar]:
        stiffness = self.friction.stiffness(memory.column, motion.rate, motion.angle)
        stiffness = stiffness + self.linkage.stiffness(motion.angle, motion.rate, memory.kingpins)
        return {("rate", "angle"): -stiffness / self._inertia()}

    def steer(self, motion: ColumnMotion) -> Steer:
        return self.linkage.steer(motion.angle, motion.rate)

    def hand(self, motion: ColumnMotion) -> Hand:
        return Hand(motion.angle, motion.rate) if self.torsion_bar is None else Hand(*motion.wheel)

    def derivative(self, motion: ColumnMotion, start: ColumnMotion, memory: ColumnMemory, loads: Loads) -> ColumnMotion:
        balance = self._balance(motion, start, memory, loads)
        return ColumnMotion(
            motion.rate,
            balance.acceleration,
            self.motor.torque_rate(motion.motor_torque, loads.actuator_torques[0], self._rotor(motion).rate),
            () if self.torsion_bar is None else Wheel(motion.wheel.rate, balance.wheel_acceleration),
            () if self.worm_gear is None else Rotor(motion.rotor.rate, balance.rotor_acceleration),
        )

    def advance(self, motion: ColumnMotion, start: ColumnMotion, memory: ColumnMemory, loads: Loads) -> ColumnMemory:
        turned = motion.angle - start.angle
        return ColumnMemory(
            self.friction.advance(memory.column, turned, motion.rate, angle=motion.angle),
            self.linkage.advance(motion.angle, motion.rate, start.angle, memory.kingpins, loads),
        )

    def signals(self, motion: ColumnMotion, memory: ColumnMemory, loads: Loads) -> SteeringSignals:
        balance = self._balance(motion, motion, memory, loads)
        level = self.friction.sliding_level(motion.angle) + self.linkage.friction_level(motion.angle)
        return steering_signals(
            self.linkage,
            self.hand(motion),
            balance.wheel_acceleration,
            balance.driver_torque,
            Shaft(motion.motor_torque, *self._rotor(motion)),
            motion.angle,
            Rack(motion.angle, motion.rate, balance.acceleration),
            balance.resistance,
            Dry(level, balance.friction + balance.resistance.friction),
        )

    def _balance(self, motion: ColumnMotion, start: ColumnMotion, memory: ColumnMemory, loads: Loads) -> _Balance:
        resistance = self.linkage.resistance(motion.angle, motion.rate, start.angle, memory.kingpins, loads)
        friction = self.friction.torque(
            memory.column,
            motion.angle - start.angle,
            motion.rate,
            resistance.kingpin / self.reference_load,
            motion.angle,
        )
        drive, rotor_acceleration = self._drive(motion)
        drive = drive - friction - resistance.total - viscous(motion.rate, self.damping)
        inertia = self._inertia()
        if self.torsion_bar is None:
            drive = drive - viscous(motion.rate, self.wheel_damping)
            acceleration = (loads.hand_torque + drive) / inertia
            return _Balance(loads.hand_torque, friction, resistance, acceleration, acceleration, rotor_acceleration)
        driver = self.torsion_bar.torque(motion.wheel, motion.angle, motion.rate)
        held = loads.hand_torque - viscous(motion.wheel.rate, self.wheel_damping)
        wheel_acceleration = (held - driver) / self.wheel_inertia
        acceleration = (driver + drive) / inertia
        return _Balance(driver, friction, resistance, acceleration, wheel_acceleration, rotor_acceleration)

    def _inertia(self) -> Scalar:
        """Inertia of all parts that move with the column [kg*m**2]."""
        inertia = self.column_inertia + self.linkage.inertia
        if self.worm_gear is None:
            inertia = inertia + self.motor.ratio * self.motor.ratio * self.motor.inertia
        return inertia if self.torsion_bar is not None else inertia + self.wheel_inertia

    def _rotor(self, motion: ColumnMotion) -> Rotor:
        if self.worm_gear is not None:
            return Rotor(*motion.rotor)
        return Rotor(self.motor.ratio * motion.angle, self.motor.ratio * motion.rate)

    def _drive(self, motion: ColumnMotion) -> tuple[Scalar, Scalar]:
        """Torque of the motor on the column without its inertia [N*m], acceleration of a separate rotor [rad/s**2]."""
        motor, gear, rotor = self.motor, self.worm_gear, self._rotor(motion)
        torque = motor.shaft_torque(motion.motor_torque, rotor.angle) - viscous(rotor.rate, motor.damping)
        if gear is None:
            return column_torque_of_motor(torque, motor.ratio), 0.0
        twist, twist_rate = rotor.angle / motor.ratio - motion.angle, rotor.rate / motor.ratio - motion.rate
        passed = lash_torque(twist, twist_rate, gear.stiffness, gear.damping, gear.play)
        return passed, (torque - passed / motor.ratio) / motor.inertia
