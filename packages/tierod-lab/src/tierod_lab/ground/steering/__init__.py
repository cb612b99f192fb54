"""Components of a steering: torsion bar, electric motor, linkage of rack, tie rods and kingpins, and the signals."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import absolute, limit, maximum, sign, sin, where
from tierod.physics.steering import road_wheel_angle, torque_at_steering_wheel, torsion_bar_torque
from tierod_lab.ground.laws import ackermann_angle, ackermann_slope, variable_ratio
from tierod_lab.ground.parts import Hand, Loads, Memory, Steer, signals
from tierod_lab.ground.steering.friction import Dahl, DryFriction


class Wheel(NamedTuple):
    """Motion of a steering wheel that a torsion bar separates from the column."""

    angle: Scalar
    rate: Scalar


@dataclass(frozen=True)
class TorsionBar:
    """Elastic torsion bar below the steering wheel; 140 N*m/rad is 2.4 N*m per degree."""

    stiffness: Annotated[float, "N*m/rad", POSITIVE] = 140.0
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.05

    def torque(self, wheel: Wheel, angle: Scalar, rate: Scalar) -> Scalar:
        """Torque on the column [N*m]."""
        return torsion_bar_torque(wheel.angle, angle, self.stiffness, wheel.rate, rate, self.damping)


@dataclass(frozen=True)
class Ripple:
    """Cogging torque and torque ripple of the strongest order, in phase with each other; of a good EPS motor."""

    cogging_torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.01  # amplitude without current
    share: Annotated[float, "", NOT_NEGATIVE] = 0.01  # amplitude per torque of the currents
    order: Annotated[float, "", POSITIVE] = 24.0  # periods per revolution of the rotor


def rippled(torque: Scalar, angle: Scalar, ripple: Ripple | None) -> Scalar:
    """Shaft torque [N*m] for an electromagnetic torque [N*m] at a rotor angle [rad]."""
    if ripple is None:
        return torque
    return torque + (ripple.cogging_torque + ripple.share * torque) * sin(ripple.order * angle)


@dataclass(frozen=True)
class SpeedLimit:
    """Torque limit due to the voltage: full torque up to the base speed, none at that without load, linear between.

    The defaults are typical: with a ratio of 20, full torque up to 430 degrees of column per second, none at 1000.
    """

    base_speed: Annotated[float, "rad/s", POSITIVE] = 150.0
    no_load_speed: Annotated[float, "rad/s", POSITIVE] = 350.0

    def __post_init__(self) -> None:
        if not self.no_load_speed > self.base_speed:
            turns = f"a motor without load turns at {self.no_load_speed:g} rad/s, which is not above its base speed"
            raise ParameterError(f"{turns} of {self.base_speed:g} rad/s; raise no_load_speed")


@dataclass(frozen=True)
class Motor:
    """Electric motor at its shaft; typical of a mid-size car with 60 N*m of assist at the column."""

    ratio: Annotated[float, "", POSITIVE] = 20.0
    inertia: Annotated[float, "kg*m**2", POSITIVE] = 1.5e-4
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 1e-3
    lag: Annotated[float, "s", POSITIVE] = 2e-3
    maximum_torque: Annotated[float, "N*m", POSITIVE] = 3.5
    ripple: Ripple | None = None  # None for a smooth motor
    speed_limit: SpeedLimit | None = None  # None for a motor without voltage limit

    def torque_rate(self, torque: Scalar, request: Scalar, speed: Scalar = 0.0) -> Scalar:
        """Rate of change of the electromagnetic torque [N*m/s].

        Args:
            torque: electromagnetic torque [N*m]
            request: requested torque [N*m]
            speed: speed of the rotor [rad/s]
        """
        # Only the torque that drives the rotor is limited by the voltage, so each sign has its own limit.
        return (limit(request, -self._most(-speed), self._most(speed)) - torque) / self.lag

    def _most(self, speed: Scalar) -> Scalar:
        bound = self.speed_limit
        if bound is None:
            return self.maximum_torque
        share = (bound.no_load_speed - speed) / (bound.no_load_speed - bound.base_speed)
        return self.maximum_torque * limit(share, 0.0, 1.0)

    def shaft_torque(self, torque: Scalar, angle: Scalar) -> Scalar:
        """Shaft torque [N*m] at a rotor angle [rad]."""
        return rippled(torque, angle, self.ripple)


def assist_motor() -> Motor:
    """Typical motor of an EPS, with its voltage limit."""
    return Motor(speed_limit=SpeedLimit())


@dataclass(frozen=True)
class EndStop:
    """End stops of the travel, referred to the pinion, beyond the 570 degrees of Mohtat et al., Appendix A."""

    angle: Annotated[float, "rad", POSITIVE] = math.radians(572.0)
    stiffness: Annotated[float, "N*m/rad", NOT_NEGATIVE] = 400.0
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 5.0

    def torque(self, angle: Scalar, rate: Scalar) -> Scalar:
        """Torque [N*m] that opposes a turn to the left; a stop pushes and never pulls."""
        depth, direction = absolute(angle) - self.angle, sign(angle)
        push = maximum(self.stiffness * depth + self.damping * direction * rate, 0.0)
        return where(depth > 0.0, direction * push, 0.0)


class Resistance(NamedTuple):
    """Torques at the pinion that oppose a turn to the left."""

    left: Scalar  # left, right: torque of each kingpin with its friction, by virtual work [N*m]
    right: Scalar
    kingpin: Scalar  # torque of tyres and road, both sides [N*m]
    friction: Scalar  # dry friction of both kingpins [N*m]
    stop: Scalar  # torque of the end stops [N*m]

    @property
    def total(self) -> Scalar:
        """Sum of tyre, friction and end-stop torque [N*m]."""
        return self.kingpin + self.friction + self.stop


@dataclass(frozen=True)
class Linkage:
    """Kinematics and losses of rack, tie rods and steering arms; typical of a mid-size car."""

    ratio: Annotated[float, "", POSITIVE] = 1.0 / 15.5
    ratio_growth: Annotated[float, "1/rad**2", ANY] = 0.0
    # see `tierod.physics.steering`; the default is about 60 % of full Ackermann
    ackermann_gain: Annotated[float, "1/rad", NOT_NEGATIVE] = 0.16
    # travel of the rack per angle of the pinion; the default is 55 mm per revolution
    rack_ratio: Annotated[float, "m/rad", POSITIVE] = 8.75e-3
    road_wheel_inertia: Annotated[float, "kg*m**2", NOT_NEGATIVE] = 0.5
    # dry friction of ball joints and struts, both kingpins together, over the mean steering angle of the road wheels,
    # depending on the front axle load; 5 to 20 N*m is typical (0.3 to 1.3 N*m at the steering wheel), the default is
    # none
    friction: DryFriction = field(
        default_factory=lambda: DryFriction(level=0.0, law=Dahl(math.radians(0.1)), load_share=0.3)
    )
    reference_load: Annotated[float, "N", POSITIVE] = 9400.0
    end_stop: EndStop = field(default_factory=EndStop)

    @property
    def inertia(self) -> float:
        """Inertia of both road wheels at the pinion, with the on-centre ratio [kg*m**2]."""
        return 2.0 * self.road_wheel_inertia * self.ratio * self.ratio

    def remembered(self) -> Memory:
        return self.friction.remembered()

    def steer(self, angle: Scalar, rate: Scalar) -> Steer:
        mean, slope, gain = self._mean(angle), self._slope(angle) * rate, self.ackermann_gain
        return Steer(
            ackermann_angle(mean, gain),
            ackermann_angle(mean, -gain),
            slope * ackermann_slope(mean, gain),
            slope * ackermann_slope(mean, -gain),
        )

    def resistance(self, angle: Scalar, rate: Scalar, start: Scalar, memory: Memory, loads: Loads) -> Resistance:
        """Resistance at the pinion.

        Args:
            angle, rate: angle [rad] and rate [rad/s] of the pinion
            start: angle of the pinion at the start of the step [rad]
        """
        mean, slope, gain = self._mean(angle), self._slope(angle), self.ackermann_gain
        friction = self.friction.torque(memory, *self._path(angle, rate, start, mean, slope), self._load(loads), mean)
        friction = torque_at_steering_wheel(friction, slope)
        left = torque_at_steering_wheel(loads.kingpin_left, slope * ackermann_slope(mean, gain))
        right = torque_at_steering_wheel(loads.kingpin_right, slope * ackermann_slope(mean, -gain))
        stop = self.end_stop.torque(angle, rate)
        return Resistance(left + 0.5 * friction, right + 0.5 * friction, left + right, friction, stop)

    def stiffness(self, angle: Scalar, rate: Scalar, memory: Memory) -> Scalar:
        """Stiffness of the dry friction at the pinion at the start of a step, see `resistance` [N*m/rad]."""
        slope = self._slope(angle)
        return slope * slope * self.friction.stiffness(memory, slope * rate, self._mean(angle))

    def advance(self, angle: Scalar, rate: Scalar, start: Scalar, memory: Memory, loads: Loads) -> Memory:
        mean, slope = self._mean(angle), self._slope(angle)
        return self.friction.advance(memory, *self._path(angle, rate, start, mean, slope), self._load(loads), mean)

    def friction_level(self, angle: Scalar) -> Scalar:
        """Friction level at the pinion [N*m]."""
        return torque_at_steering_wheel(self.friction.sliding_level(self._mean(angle)), self._slope(angle))

    def _path(self, angle: Scalar, rate: Scalar, start: Scalar, mean: Scalar, slope: Scalar) -> tuple[Scalar, Scalar]:
        return mean - self._mean(start), slope * rate

    def _load(self, loads: Loads) -> Scalar:
        return loads.front_load / self.reference_load

    def _mean(self, angle: Scalar) -> Scalar:
        return road_wheel_angle(angle, self.ratio, self.ratio_growth)

    def _slope(self, angle: Scalar) -> Scalar:
        return variable_ratio(angle, self.ratio, self.ratio_growth)


SteeringSignals = signals(
    "SteeringSignals",
    """steering_wheel_angle steering_wheel_rate driver_torque motor_torque motor_angle_mechanical motor_speed
    pinion_angle rack_position rack_speed rack_force tie_rod_force_left tie_rod_force_right road_wheel_angle_left
    road_wheel_angle_right truth_friction_torque[N*m] truth_friction_resistance[N*m]
    truth_steering_wheel_acceleration[rad/s**2]""",
)
"""Signals before sensors, and quantities without a sensor (`truth_`).

`truth_friction_torque` is the sliding level of all dry friction about the steering wheel's axis, at the reference
loads and the present angle; `truth_friction_resistance` is the present torque of all dry friction, with its sign.
"""


class Shaft(NamedTuple):
    """Motion of a rotor: electromagnetic torque [N*m], angle [rad] and rate [rad/s]."""

    torque: Scalar
    angle: Scalar
    rate: Scalar


class Rack(NamedTuple):
    """Motion of a rack, referred to the pinion: angle [rad], rate [rad/s] and acceleration [rad/s**2]."""

    angle: Scalar
    rate: Scalar
    acceleration: Scalar


class Dry(NamedTuple):
    """Dry friction of a whole steering about the steering wheel's axis: level and signed torque [N*m]."""

    level: Scalar
    torque: Scalar


def steering_signals(
    linkage: Linkage,
    hand: Hand,
    hand_acceleration: Scalar,
    driver_torque: Scalar,
    motor: Shaft,
    pinion_angle: Scalar,
    rack: Rack,
    resistance: Resistance,
    dry: Dry,
) -> Tree:
    """Signals of a steering; the tie-rod forces follow from the balance of moments of their road wheels.

    Args:
        hand, hand_acceleration: motion of the steering wheel, its acceleration in [rad/s**2]
        driver_torque: torque in the torsion bar [N*m]
        pinion_angle: angle of the pinion [rad]
    """
    steer = linkage.steer(rack.angle, rack.rate)
    swing = 0.5 * linkage.inertia * rack.acceleration
    left = (resistance.left + swing) / linkage.rack_ratio
    right = (resistance.right + swing) / linkage.rack_ratio
    return SteeringSignals(
        *hand,
        driver_torque,
        *motor,
        pinion_angle,
        linkage.rack_ratio * rack.angle,
        linkage.rack_ratio * rack.rate,
        left + right,
        left,
        right,
        steer.left,
        steer.right,
        *dry,
        hand_acceleration,
    )
