"""Electric power steering with the motor on the column."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.physics.friction import viscous
from tierod.physics.steering_ratio import column_torque_of_motor
from tierod.proving_ground.parts import Hand, Loads, Steer
from tierod.proving_ground.steering.friction import DryFriction
from tierod.proving_ground.steering.linkage import Linkage
from tierod.proving_ground.steering.observed import SteeringSignals
from tierod.proving_ground.steering.torsion_bar import TorsionBar, Wheel
from tierod.ranges import NOT_NEGATIVE, POSITIVE


class ColumnMotion(NamedTuple):
    """What the differential equations of a column carry on; the wheel is () where the bar is rigid."""

    angle: Any
    rate: Any
    motor_torque: Any
    wheel: Any


class _Balance(NamedTuple):
    driver_torque: Any
    friction: Any
    kingpin: Any
    column_acceleration: Any
    wheel_acceleration: Any


@dataclass(frozen=True)
class ColumnEps:
    """Steering wheel, torsion bar, column with motor, and gear; typical of a mid-size car.

    Args:
        wheel_inertia: of the steering wheel
        column_inertia: of column, pinion, rack and road wheels, referred to the column
        rotor_inertia: of the motor, at its shaft
        motor_gear: turn of the motor per turn of the column
        motor_lag: time constant of the current control
        damping: viscous, at the column
        friction: at the column
        linkage: from the pinion to the road wheels
        torsion_bar: None for a rigid column
    """

    wheel_inertia: Annotated[float, "kg*m**2", POSITIVE] = 0.035
    column_inertia: Annotated[float, "kg*m**2", POSITIVE] = 0.005
    rotor_inertia: Annotated[float, "kg*m**2", NOT_NEGATIVE] = 1.5e-4
    motor_gear: Annotated[float, "", POSITIVE] = 20.0
    motor_lag: Annotated[float, "s", POSITIVE] = 2e-3
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.8
    friction: DryFriction = field(default_factory=DryFriction)
    linkage: Linkage = field(default_factory=Linkage)
    torsion_bar: TorsionBar | None = field(default_factory=TorsionBar)

    @property
    def actuators(self) -> tuple[str, ...]:
        """The assist motor."""
        return ("motor_torque",)

    def init(self) -> ColumnMotion:
        """Straight ahead, at rest."""
        return ColumnMotion(0.0, 0.0, 0.0, () if self.torsion_bar is None else Wheel(0.0, 0.0))

    def remembered(self) -> Any:
        """Friction relaxed."""
        return self.friction.remembered()

    def stiff(self) -> ColumnMotion:
        """Straight ahead, at rest."""
        return self.init()

    def steer(self, motion: ColumnMotion) -> Steer:
        """Of the road wheels."""
        return self.linkage.steer(motion.angle, motion.rate)

    def hand(self, motion: ColumnMotion) -> Hand:
        """Of the steering wheel."""
        return Hand(motion.angle, motion.rate) if self.torsion_bar is None else Hand(*motion.wheel)

    def derivative(self, motion: ColumnMotion, start: ColumnMotion, memory: Any, loads: Loads) -> ColumnMotion:
        """Rate of change of the motion."""
        balance = self._balance(motion, start, memory, loads)
        (request,) = loads.actuator_torques
        wheel = () if self.torsion_bar is None else Wheel(motion.wheel.rate, balance.wheel_acceleration)
        return ColumnMotion(
            motion.rate, balance.column_acceleration, (request - motion.motor_torque) / self.motor_lag, wheel
        )

    def advance(self, motion: ColumnMotion, start: ColumnMotion, memory: Any, loads: Loads) -> Any:
        """Friction after a step."""
        kingpin = self.linkage.ratios(motion.angle).torque(loads.kingpin_left, loads.kingpin_right)
        return self.friction.advance(memory, motion.angle - start.angle, motion.rate, kingpin, motion.angle)

    def signals(self, motion: ColumnMotion, memory: Any, loads: Loads) -> SteeringSignals:
        """What can be seen at one instant."""
        balance = self._balance(motion, motion, memory, loads)
        ratios, steer, hand = self.linkage.ratios(motion.angle), self.steer(motion), self.hand(motion)
        rack = self.linkage.rack_ratio
        left, right = ratios.left * loads.kingpin_left / rack, ratios.right * loads.kingpin_right / rack
        return SteeringSignals(
            steering_wheel_angle=hand.angle,
            steering_wheel_rate=hand.rate,
            driver_torque=balance.driver_torque,
            motor_torque=motion.motor_torque,
            motor_angle_mechanical=self.motor_gear * motion.angle,
            motor_speed=self.motor_gear * motion.rate,
            pinion_angle=motion.angle,
            rack_position=rack * motion.angle,
            rack_speed=rack * motion.rate,
            rack_force=left + right,
            tie_rod_force_left=left,
            tie_rod_force_right=right,
            road_wheel_angle_left=steer.left,
            road_wheel_angle_right=steer.right,
            truth_friction_torque=self.friction.level,
            truth_friction_resistance=balance.friction,
            truth_steering_wheel_acceleration=balance.wheel_acceleration,
        )

    def _balance(self, motion: ColumnMotion, start: ColumnMotion, memory: Any, loads: Loads) -> _Balance:
        bar = self.torsion_bar
        below = self.column_inertia + self.motor_gear * self.motor_gear * self.rotor_inertia
        kingpin = self.linkage.ratios(motion.angle).torque(loads.kingpin_left, loads.kingpin_right)
        friction = self.friction.torque(memory, motion.angle - start.angle, motion.rate, kingpin, motion.angle)
        resistance = friction + kingpin + viscous(motion.rate, self.damping)
        drive = column_torque_of_motor(motion.motor_torque, self.motor_gear) - resistance
        if bar is None:
            acceleration = (loads.hand_torque + drive) / (below + self.wheel_inertia)
            return _Balance(loads.hand_torque, friction, kingpin, acceleration, acceleration)
        driver = bar.torque(motion.wheel, motion.angle, motion.rate)
        wheel_acceleration = (loads.hand_torque - driver) / self.wheel_inertia
        return _Balance(driver, friction, kingpin, (driver + drive) / below, wheel_acceleration)
