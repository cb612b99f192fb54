"""Automated driver, which follows a path and keeps a speed with target angle, target torques and sensed signals."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.core.graph.maths import arctan, limit, maximum, where
from tierod.physics.planar_motion import pursuit_curvature
from tierod.physics.single_track import steady_road_wheel_angle
from tierod_lab.ground.control.angle_control import AngleControl, AngleMemory, SpeedControl
from tierod_lab.ground.parts import Demand, Hand, Intent, Seen


class Sensed(NamedTuple):
    """Sensor readings: speed [m/s], yaw rate [rad/s], steering-wheel angle [rad]."""

    speed: Scalar
    yaw_rate: Scalar
    steering_wheel_angle: Scalar


class Targets(NamedTuple):
    """Targets of the automated driver."""

    steering_wheel_angle: Scalar  # target angle [rad]
    speed: Scalar  # target speed [m/s]
    # steering_torque_1, steering_torque_2: torques of the steering motors, at the column [N*m]
    steering_torque_1: Scalar
    steering_torque_2: Scalar
    force: Scalar  # force along the road [N]
    drive_difference: Scalar  # torque of the right wheel minus that of the left one [N*m]


class Command(NamedTuple):
    """State of the automated driver: its controls, last target angle [rad], and time within the split period [s]."""

    angle: AngleMemory
    speed: Scalar
    target: Scalar
    time: Scalar


@dataclass(frozen=True)
class Split:
    """Split of the steering torque between two motors."""

    share: Annotated[float, "", SHARE] = 0.5
    swing: Annotated[float, "", SHARE] = 0.0
    period: Annotated[float, "s", POSITIVE] = 0.24

    def first(self, time: Scalar) -> Scalar:
        """Share of the first motor at a time within the period [-]."""
        return self.share + where(time < 0.5 * self.period, self.swing, -self.swing)


@dataclass(frozen=True)
class AutomatedDriver:
    """Pure pursuit with preview of the path's curvature, angle control for two steering motors, and speed control.

    Localisation (offset and heading relative to the path) is exact; speed, yaw rate and steering-wheel angle come from
    sensors. The driver's model of the car has its own parameters.
    """

    # mass, wheelbase, understeer_gradient, steering_ratio: parameters of the driver's model; the ratio is road wheel
    # per steering wheel
    mass: Annotated[float, "kg", POSITIVE] = 403.2
    wheelbase: Annotated[float, "m", POSITIVE] = 2.07
    understeer_gradient: Annotated[float, "rad*s**2/m", ANY] = 1.5e-3
    steering_ratio: Annotated[float, "", POSITIVE] = 1.0 / 19.7
    anticipation: Annotated[float, "s", NOT_NEGATIVE] = 0.15
    preview_time: Annotated[float, "s", POSITIVE] = 0.8
    least_preview: Annotated[float, "m", POSITIVE] = 3.0
    correction: Annotated[float, "", NOT_NEGATIVE] = 1.0
    yaw_feedback: Annotated[float, "s", NOT_NEGATIVE] = 0.03
    target_rate: Annotated[float, "rad/s", POSITIVE] = 8.0
    angle_control: AngleControl = field(
        default_factory=lambda: AngleControl(
            stiffness=40.0, damping=1.0, integral=120.0, torque_limit=30.0, forward_damping=1.0
        )
    )
    split: Split = field(default_factory=Split)
    # drive torque difference per steering torque; above zero, the wheel motors support the steering
    drive_steering: Annotated[float, "", NOT_NEGATIVE] = 0.0
    speed_control: SpeedControl = field(default_factory=SpeedControl)
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    def init(self) -> tuple[()]:
        return ()

    def remembered(self) -> tuple[()]:
        return ()

    def decide(self, memory: tuple[()], seen: Seen, demand: Demand) -> tuple[tuple[()], Intent]:
        return (), Intent(0.0, 0.0)

    def hand_torque(self, motion: tuple[()], hand: Hand, demand: Demand) -> Scalar:
        return demand.hand_torque

    def derivative(self, motion: tuple[()], intent: Intent, hand: Hand, demand: Demand) -> tuple[()]:
        return ()

    def reset(self) -> Command:
        return Command(self.angle_control.remembered(), self.speed_control.remembered(), 0.0, 0.0)

    def command(self, memory: Command, seen: Seen, demand: Demand, sensed: Sensed) -> tuple[Command, Targets]:
        """Compute all targets from the sensed signals, once per step."""
        most = self.target_rate * self.step_time
        target = limit(self._wanted_angle(seen, demand, sensed), memory.target - most, memory.target + most)
        angle, torque = self.angle_control.decide(memory.angle, target, sensed.steering_wheel_angle)
        speed, acceleration = self.speed_control.decide(memory.speed, demand.speed, demand.acceleration, sensed.speed)
        first = self.split.first(memory.time) * torque
        time = memory.time + self.step_time
        # The tolerance of half a step keeps rounding from lengthening a period by one step.
        time = where(time < self.split.period - 0.5 * self.step_time, time, 0.0)
        targets = Targets(
            target,
            demand.speed,
            first,
            torque - first,
            self.mass * acceleration,
            self.drive_steering * torque,
        )
        return Command(angle, speed, target, time), targets

    def _wanted_angle(self, seen: Seen, demand: Demand, sensed: Sensed) -> Scalar:
        """Steering-wheel angle that follows the path [rad]."""
        reach = maximum(self.preview_time * sensed.speed, self.least_preview)
        ahead = seen.lateral_offset + self.preview_time * seen.offset_rate
        back = self.correction * demand.attention * pursuit_curvature(ahead, reach)
        steer = arctan(
            steady_road_wheel_angle(
                demand.curvature_ahead + back, sensed.speed, self.wheelbase, self.understeer_gradient
            )
        )
        steer = steer - self.yaw_feedback * demand.attention * (sensed.yaw_rate - sensed.speed * seen.curvature)
        return demand.steering_wheel_angle + steer / self.steering_ratio
