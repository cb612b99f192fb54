"""Steer-by-wire: an actuator turns the road wheels, and a feedback unit applies a torque to the hands."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE
from tierod.physics.friction import viscous
from tierod.physics.steering import column_torque_of_motor
from tierod_lab.ground.parts import Hand, Loads, Memory, Steer, signals
from tierod_lab.ground.steering import Linkage, Motor, Resistance
from tierod_lab.ground.steering.friction import Dahl, DryFriction


class HandWheelMotion(NamedTuple):
    """Angle [rad] and rate [rad/s] of the steering wheel, and torque of the feedback motor [N*m]."""

    angle: Scalar
    rate: Scalar
    torque: Scalar


class SteerByWireMotion(NamedTuple):
    """Angle [rad] and rate [rad/s] of the pinion, shaft torque of the actuator [N*m], and steering wheel motion."""

    angle: Scalar
    rate: Scalar
    motor_torque: Scalar
    wheel: HandWheelMotion


class SteerByWireMemory(NamedTuple):
    """Memory of the dry friction of the road wheels and of the steering wheel."""

    road_wheels: Memory
    wheel: Memory


SteerByWireSignals = signals(
    "SteerByWireSignals",
    """steering_wheel_angle steering_wheel_rate driver_torque feedback_torque road_wheel_angle road_wheel_rate
    road_wheel_angle_left road_wheel_angle_right pinion_angle rack_position motor_torque motor_current
    road_wheel_torque truth_road_wheel_friction[N*m] truth_road_wheel_friction_level[N*m]
    truth_road_wheel_acceleration[rad/s**2]""",
)
"""Signals before sensors, and quantities without a sensor (`truth_`); friction is referred to the road wheels.

The driver torque is measured between steering wheel and feedback motor, above the friction of the feedback unit.
"""


@dataclass(frozen=True)
class HandWheel:
    """Steering wheel on a shaft that ends at the feedback motor; assumed values."""

    inertia: Annotated[float, "kg*m**2", POSITIVE] = 0.035
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.05
    friction: DryFriction = field(default_factory=lambda: DryFriction(level=0.3))


class _Balance(NamedTuple):
    driving: Scalar
    resistance: Resistance
    acceleration: Scalar
    wheel_friction: Scalar
    wheel_acceleration: Scalar


@dataclass(frozen=True)
class SteerByWire:
    """Actuator, power assist, rack and road wheels, and a steering wheel that is connected to them by control alone.

    J_w delta'' + b_w delta' + tau_f + tau_a = r_s r_p r_g eta tau_motor, with dry friction that builds up over an angle
    instead of the sign function. The defaults represent a sports car whose column was removed and whose hydraulic
    assist was kept; none of them is printed. Source: Yih, Ryu, Gerdes, eqs (1), (2) and (5).
    """

    # inertia of gear, assist and rack, at the road wheels; with rotor and road wheels J_w = 3.5 kg*m**2
    inertia: Annotated[float, "kg*m**2", NOT_NEGATIVE] = 0.874
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 160.0
    power_assist: Annotated[float, "", POSITIVE] = 3.0
    efficiency: Annotated[float, "", SHARE] = 0.7
    motor: Motor = field(default_factory=lambda: Motor(ratio=75.0, inertia=1e-6, damping=0.0, maximum_torque=0.9))
    torque_constant: Annotated[float, "N*m/A", POSITIVE] = 0.06
    # linkage from the pinion to the road wheels, 1/r_s; its friction is F_w
    linkage: Linkage = field(
        default_factory=lambda: Linkage(
            ratio=1.0 / 17.0, road_wheel_inertia=0.5, friction=DryFriction(level=30.0, law=Dahl(math.radians(0.1)))
        )
    )
    hand_wheel: HandWheel = field(default_factory=HandWheel)
    feedback: Motor = field(default_factory=lambda: Motor(ratio=1.0, inertia=2e-3, damping=0.0, maximum_torque=8.0))

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("motor_torque", "feedback_torque")

    def init(self) -> SteerByWireMotion:
        return SteerByWireMotion(0.0, 0.0, 0.0, HandWheelMotion(0.0, 0.0, 0.0))

    def remembered(self) -> SteerByWireMemory:
        return SteerByWireMemory(self.linkage.remembered(), self.hand_wheel.friction.remembered())

    def stiff(self) -> SteerByWireMotion:
        return self.init()

    def sticking(self, motion: SteerByWireMotion, memory: SteerByWireMemory) -> dict[tuple[str, str], Scalar]:
        road = self.linkage.stiffness(motion.angle, motion.rate, memory.road_wheels)
        hands = self.hand_wheel.friction.stiffness(memory.wheel, motion.wheel.rate)
        return {
            ("rate", "angle"): -road / self._inertia(),
            ("wheel.rate", "wheel.angle"): -hands / self._hand_inertia(),
        }

    def steer(self, motion: SteerByWireMotion) -> Steer:
        return self.linkage.steer(motion.angle, motion.rate)

    def hand(self, motion: SteerByWireMotion) -> Hand:
        return Hand(motion.wheel.angle, motion.wheel.rate)

    def derivative(
        self, motion: SteerByWireMotion, start: SteerByWireMotion, memory: SteerByWireMemory, loads: Loads
    ) -> SteerByWireMotion:
        balance, (road, feedback) = self._balance(motion, start, memory, loads), loads.actuator_torques
        wheel, torque_rate = motion.wheel, self.feedback.torque_rate(motion.wheel.torque, feedback)
        hands = HandWheelMotion(wheel.rate, balance.wheel_acceleration, torque_rate)
        return SteerByWireMotion(
            motion.rate, balance.acceleration, self.motor.torque_rate(motion.motor_torque, road), hands
        )

    def advance(
        self, motion: SteerByWireMotion, start: SteerByWireMotion, memory: SteerByWireMemory, loads: Loads
    ) -> SteerByWireMemory:
        wheel = motion.wheel
        return SteerByWireMemory(
            self.linkage.advance(motion.angle, motion.rate, start.angle, memory.road_wheels, loads),
            self.hand_wheel.friction.advance(memory.wheel, wheel.angle - start.wheel.angle, wheel.rate),
        )

    def signals(self, motion: SteerByWireMotion, memory: SteerByWireMemory, loads: Loads) -> Tree:
        balance, linkage, steer = self._balance(motion, motion, memory, loads), self.linkage, self.steer(motion)
        wheel, ratio = motion.wheel, linkage.ratio
        return SteerByWireSignals(
            wheel.angle,
            wheel.rate,
            loads.hand_torque - self.hand_wheel.inertia * balance.wheel_acceleration,
            wheel.torque,
            0.5 * (steer.left + steer.right),
            0.5 * (steer.left_rate + steer.right_rate),
            *steer[:2],
            motion.angle,
            linkage.rack_ratio * motion.angle,
            motion.motor_torque,
            motion.motor_torque / self.torque_constant,
            balance.driving / ratio,
            balance.resistance.friction / ratio,
            linkage.friction_level(motion.angle) / ratio,
            balance.acceleration * ratio,
        )

    def _balance(
        self, motion: SteerByWireMotion, start: SteerByWireMotion, memory: SteerByWireMemory, loads: Loads
    ) -> _Balance:
        ratio, unit, wheel = self.linkage.ratio, self.hand_wheel, motion.wheel
        torque = self.motor.shaft_torque(motion.motor_torque, self.motor.ratio * motion.angle)
        driving = self.power_assist * self.efficiency * column_torque_of_motor(torque, self.motor.ratio)
        resistance = self.linkage.resistance(motion.angle, motion.rate, start.angle, memory.road_wheels, loads)
        friction = unit.friction.torque(memory.wheel, wheel.angle - start.wheel.angle, wheel.rate)
        friction = friction + viscous(wheel.rate, unit.damping)
        return _Balance(
            driving,
            resistance,
            (driving - resistance.total - viscous(motion.rate, ratio * ratio * self.damping)) / self._inertia(),
            friction,
            (loads.hand_torque + self.feedback.ratio * wheel.torque - friction) / self._hand_inertia(),
        )

    def _inertia(self) -> Scalar:
        """Inertia of all parts that move with the road wheels, at the pinion [kg*m**2]."""
        linkage, motor = self.linkage, self.motor
        rotor = motor.ratio * motor.ratio * motor.inertia
        return linkage.ratio * linkage.ratio * self.inertia + linkage.inertia + rotor

    def _hand_inertia(self) -> Scalar:
        """Inertia of steering wheel and feedback motor [kg*m**2]."""
        return self.hand_wheel.inertia + self.feedback.ratio * self.feedback.ratio * self.feedback.inertia
