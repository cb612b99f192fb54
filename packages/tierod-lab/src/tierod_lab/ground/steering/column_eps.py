"""Electric power steering with the motor on the column, alone and below a superposition gear."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.physics.friction import viscous
from tierod.physics.steering import column_torque_of_motor, superposed_angle
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
from tierod_lab.ground.steering.friction import DryFriction


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

    def signals(self, motion: ColumnMotion, memory: ColumnMemory, loads: Loads) -> Tree:
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
        turned, load = motion.angle - start.angle, resistance.kingpin / self.reference_load
        friction = self.friction.torque(memory.column, turned, motion.rate, load, motion.angle)
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


class ActiveFrontMotion(NamedTuple):
    """Column below the gear, steering wheel above it, and the angle of the superposition motor."""

    column: ColumnMotion
    motor_angle: Scalar


ActiveFrontSignals = signals(
    "ActiveFrontSignals",
    """steering_wheel_angle steering_wheel_rate driver_torque column_assist_torque pinion_angle pinion_rate
    rack_position rack_force tie_rod_force_left tie_rod_force_right road_wheel_angle_left road_wheel_angle_right
    truth_gear_input_angle[rad] truth_friction_torque[N*m] truth_friction_resistance[N*m]""",
)
"""Signals of the steering before sensors; those of the motor come from its drive.

`truth_gear_input_angle` is the angle of the shaft that enters the gear, below the torsion bar; the friction is
defined as in `SteeringSignals`.
"""


@dataclass(frozen=True)
class ActiveFront:
    """Steering wheel, torsion bar, superposition gear with its motor, and below it a column with assist.

    Pinion = motor / i_M + shaft from the steering wheel / i_D; the gear is rigid, so that only the torsion bar is
    elastic between hands and motor. The rotor is not part of the column: its drive integrates it at its own, higher
    rate, supplies its speed, and obtains the load torque from `motor_load`.

    Args:
        column: column below the gear; its torsion bar and assist motor are referred to the pinion
    """

    column: ColumnEps = field(
        default_factory=lambda: ColumnEps(
            motor=Motor(ratio=1.0, inertia=0.06, damping=0.4, lag=2e-3, maximum_torque=60.0)
        )
    )
    motor_ratio: Annotated[float, "", POSITIVE] = 22.5
    input_ratio: Annotated[float, "", POSITIVE] = 1.0

    def __post_init__(self) -> None:
        if self.column.torsion_bar is None:
            raise ParameterError("the column of an ActiveFront has no torsion bar; give ColumnEps a TorsionBar")

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("column_assist_torque", "motor_speed")

    def init(self) -> ActiveFrontMotion:
        return ActiveFrontMotion(self.column.init(), 0.0)

    def remembered(self) -> ColumnMemory:
        return self.column.remembered()

    def stiff(self) -> ActiveFrontMotion:
        return ActiveFrontMotion(self.column.stiff(), 0.0)

    def sticking(self, motion: ActiveFrontMotion, memory: ColumnMemory) -> dict[tuple[str, str], Scalar]:
        entries = self.column.sticking(motion.column, memory)
        return {(f"column.{rate}", f"column.{angle}"): entry for (rate, angle), entry in entries.items()}

    def steer(self, motion: ActiveFrontMotion) -> Steer:
        return self.column.steer(motion.column)

    def hand(self, motion: ActiveFrontMotion) -> Hand:
        return Hand(*motion.column.wheel)

    def motor_load(self, signals: Tree, angle: Scalar, speed: Scalar, elapsed: Scalar) -> Scalar:
        """Load torque of the gear on the motor [N*m]; steering wheel and pinion are extrapolated at constant rate.

        Args:
            angle, speed: angle [rad] and speed [rad/s] of the motor
            elapsed: time since the start of the step [s]
        """
        bar = self.column.torsion_bar
        assert bar is not None
        hand = Hand(signals.steering_wheel_angle + elapsed * signals.steering_wheel_rate, signals.steering_wheel_rate)
        pinion = signals.pinion_angle + elapsed * signals.pinion_rate
        torque = bar.torque(self._superposed(angle, speed, hand), pinion, signals.pinion_rate)
        return torque / self.motor_ratio

    def derivative(
        self, motion: ActiveFrontMotion, start: ActiveFrontMotion, memory: ColumnMemory, loads: Loads
    ) -> ActiveFrontMotion:
        speed, column, wheel = loads.actuator_torques[1], self.column, self.hand(motion)
        seen = self._seen(motion, speed)
        rates = column.derivative(seen, start.column, memory, self._below(loads))
        assert column.torsion_bar is not None
        shaft = column.torsion_bar.torque(seen.wheel, seen.angle, seen.rate) / self.input_ratio
        turning = loads.hand_torque - viscous(wheel.rate, column.wheel_damping) - shaft
        # The steering wheel's own balance replaces that of the column, whose wheel is the upper end of the torsion bar.
        return ActiveFrontMotion(rates._replace(wheel=Wheel(wheel.rate, turning / column.wheel_inertia)), speed)

    def advance(
        self, motion: ActiveFrontMotion, start: ActiveFrontMotion, memory: ColumnMemory, loads: Loads
    ) -> ColumnMemory:
        return self.column.advance(motion.column, start.column, memory, self._below(loads))

    def signals(self, motion: ActiveFrontMotion, memory: ColumnMemory, loads: Loads) -> Tree:
        seen = self._seen(motion, loads.actuator_torques[1])
        below, column = self.column.signals(seen, memory, self._below(loads)), motion.column
        return ActiveFrontSignals(
            column.wheel.angle,
            column.wheel.rate,
            below.driver_torque / self.input_ratio,
            below.motor_torque,
            column.angle,
            column.rate,
            below.rack_position,
            below.rack_force,
            below.tie_rod_force_left,
            below.tie_rod_force_right,
            below.road_wheel_angle_left,
            below.road_wheel_angle_right,
            self.input_ratio * (column.angle - motion.motor_angle / self.motor_ratio),
            below.truth_friction_torque,
            below.truth_friction_resistance,
        )

    def _superposed(self, motor_angle: Scalar, motor_speed: Scalar, hand: Hand) -> Wheel:
        return Wheel(
            superposed_angle(motor_angle, hand.angle, self.motor_ratio, self.input_ratio),
            superposed_angle(motor_speed, hand.rate, self.motor_ratio, self.input_ratio),
        )

    def _seen(self, motion: ActiveFrontMotion, motor_speed: Scalar) -> ColumnMotion:
        return motion.column._replace(wheel=self._superposed(motion.motor_angle, motor_speed, self.hand(motion)))

    def _below(self, loads: Loads) -> Loads:
        return loads._replace(actuator_torques=loads.actuator_torques[:1])
