"""Drivers: a human with eyes, arms and a foot, an automated one, and either as a block for a foreign vehicle."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Ring, Scalar
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE, Range
from tierod.core.graph.maths import absolute, arctan, both, limit, maximum, minimum, where
from tierod_lab.ground.control import AngleControl, AngleMemory, SpeedControl
from tierod_lab.ground.integration import START, Path, path_rate, runge_kutta
from tierod_lab.ground.laws import pursuit_curvature, steady_road_wheel_angle
from tierod_lab.ground.parts import Demand, Driver, Hand, Intent, Memory, Motion, Reaction, Road, Seen

STANDING = 0.02  # Speed below which a car is at standstill [m/s]


class Foot(NamedTuple):
    """State of the foot, as accelerations [m/s**2]."""

    learnt: Scalar
    pressed: Scalar
    resting: Scalar


@dataclass(frozen=True)
class Pedals:
    """Speed controller with feed-forward of the planned acceleration and PI action on the speed error.

    With the defaults both poles of the closed loop are near -0.5 1/s. Braking is reduced at walking pace, because an
    abrupt stop makes the tyres push the car back. When the target is zero and the car has almost stopped, the foot
    rests on the brake until the target rises.
    """

    proportional: Annotated[float, "1/s", POSITIVE] = 1.0
    integral: Annotated[float, "1/s**2", NOT_NEGATIVE] = 0.25
    learnt_limit: Annotated[float, "m/s**2", NOT_NEGATIVE] = 2.0
    foot_time: Annotated[float, "s", POSITIVE] = 0.15
    strongest_acceleration: Annotated[float, "m/s**2", POSITIVE] = 5.0
    strongest_braking: Annotated[float, "m/s**2", POSITIVE] = 9.0
    easing_speed: Annotated[float, "m/s", POSITIVE] = 0.8
    last_share: Annotated[float, "", SHARE] = 0.2
    holding: Annotated[float, "m/s**2", POSITIVE] = 3.0
    resting_speed: Annotated[float, "m/s", POSITIVE] = 0.3
    resting_rate: Annotated[float, "m/s**3", POSITIVE] = 3.0

    def remembered(self) -> Foot:
        return Foot(0.0, 0.0, 0.0)

    def press(
        self, foot: Foot, speed: Scalar, wanted_speed: Scalar, planned: Scalar, step: Scalar
    ) -> tuple[Foot, Scalar]:
        """State of the foot after a step [s], and the acceleration that it commands [m/s**2].

        Args:
            speed, wanted_speed: forward speed and target [m/s]
            planned: acceleration of the target [m/s**2]
        """
        error = wanted_speed - speed
        asked = self._eased(planned + self.proportional * error, speed) + foot.learnt
        wanted = limit(asked, -self.strongest_braking, self.strongest_acceleration)
        halting = both(wanted_speed < 0.5 * self.resting_speed, speed < self.resting_speed)
        # The brake force of the resting foot grows until standstill.
        growing = minimum(foot.resting + step * self.resting_rate, self.holding)
        resting = where(halting, where(speed < STANDING, self.holding, growing), 0.0)
        wanted = where(halting, minimum(wanted, -resting), wanted)
        # Anti-windup: the integral stops at the limits of the request, and near standstill.
        learning = where(both(wanted == asked, speed >= self.resting_speed), self.integral * error, 0.0)
        learnt = limit(foot.learnt + step * learning, -self.learnt_limit, self.learnt_limit)
        pressed = foot.pressed + step / self.foot_time * (wanted - foot.pressed)
        return Foot(learnt, pressed, resting), pressed

    def _eased(self, acceleration: Scalar, speed: Scalar) -> Scalar:
        """Acceleration with braking reduced at walking pace [m/s**2]."""
        share = self.last_share + (1.0 - self.last_share) * limit(speed / self.easing_speed, 0.0, 1.0)
        return where(acceleration < 0.0, share * acceleration, acceleration)


class Muscles(NamedTuple):
    """State of the arms: angle [rad] and rate [rad/s] of the muscles, and integral of the angle error [rad]."""

    angle: Scalar
    rate: Scalar
    persistent_angle: Scalar


class Mind(NamedTuple):
    """Memory of a driver: offsets within the reaction delay, filtered curvature of the path, and the foot."""

    offset_ahead: Ring
    curvature: Scalar
    foot: Foot


@dataclass(frozen=True)
class HumanDriver:
    """Driver who previews the road's curvature, corrects the lateral offset after a delay, and steers with the arms.

    The arms are a spring and damper that pull the wheel towards the angle of the muscles; the muscles follow the target
    angle with a critically damped second-order lag. After Pick and Cole, Vehicle System Dynamics 46 (2008). The
    driver's internal model of the car has its own parameters, which may differ from the true ones.
    """

    mass: Annotated[float, "kg", POSITIVE] = 1600.0
    wheelbase: Annotated[float, "m", POSITIVE] = 2.83
    understeer_gradient: Annotated[float, "rad*s**2/m", ANY] = 3.73e-3
    # distance from the centre of gravity to the rear axle in the driver's model; the curvature is filtered over it,
    # since the centre of gravity turns in before the rear axle
    rear_distance: Annotated[float, "m", POSITIVE] = 1.69
    steering_ratio: Annotated[float, "", POSITIVE] = 1.0 / 15.5
    arm_stiffness: Annotated[float, "N*m/rad", POSITIVE] = 40.0
    arm_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 2.0
    muscle_time: Annotated[float, "s", POSITIVE] = 0.08
    torque_limit: Annotated[float, "N*m", POSITIVE] = 15.0
    preview_time: Annotated[float, "s", POSITIVE] = 1.5
    anticipation: Annotated[float, "s", NOT_NEGATIVE] = 0.25
    correction: Annotated[float, "", NOT_NEGATIVE] = 1.5
    greatest_offset: Annotated[float, "m", POSITIVE] = 1.5
    expected_effort: Annotated[float, "N*m*s**2/m", NOT_NEGATIVE] = 0.8
    # integral gain on the angle error, for a driver who has to reach an angle (no attention to a lane, hands on the
    # wheel)
    persistence: Annotated[float, "1/s", NOT_NEGATIVE] = 3.0
    slowest_correction: Annotated[float, "m/s", POSITIVE] = 3.0
    pedals: Pedals = field(default_factory=Pedals)
    step_time: Annotated[float, "s", POSITIVE] = 1e-3
    delay_steps: int = 150

    def init(self) -> Muscles:
        return Muscles(0.0, 0.0, 0.0)

    def remembered(self) -> Mind:
        return Mind(Ring(self.delay_steps), 0.0, self.pedals.remembered())

    def decide(self, memory: Mind, seen: Seen, demand: Demand) -> tuple[Mind, Intent]:
        foot, acceleration = self.pedals.press(
            memory.foot, seen.speed, demand.speed, demand.acceleration, self.step_time
        )
        attention = demand.attention * limit(seen.speed / self.slowest_correction, 0.0, 1.0)
        offset = memory.offset_ahead.oldest
        gone = minimum(absolute(seen.speed) * self.step_time / self.rear_distance, 1.0)
        ahead = memory.curvature + gone * (demand.curvature_ahead - memory.curvature)
        # This curvature would lead back to the path over the preview distance.
        reach = self.preview_time * maximum(seen.speed, self.slowest_correction)
        curvature = ahead + self.correction * pursuit_curvature(attention * offset, reach)
        steer = arctan(steady_road_wheel_angle(curvature, seen.speed, self.wheelbase, self.understeer_gradient))
        pressed = self.expected_effort * seen.speed * seen.speed * ahead / self.arm_stiffness
        wanted = demand.steering_wheel_angle + steer / self.steering_ratio + pressed
        near = limit(seen.lateral_offset, -self.greatest_offset, self.greatest_offset)
        noticed = memory.offset_ahead.push(near + self.preview_time * seen.offset_rate)
        return Mind(noticed, ahead, foot), Intent(wanted, self.mass * acceleration)

    def hand_torque(self, motion: Muscles, hand: Hand, demand: Demand) -> Scalar:
        arms = self.arm_stiffness * (motion.angle - hand.angle) + self.arm_damping * (motion.rate - hand.rate)
        return limit(demand.grip * arms, -self.torque_limit, self.torque_limit) + demand.hand_torque

    def derivative(self, motion: Muscles, intent: Intent, hand: Hand, demand: Demand) -> Muscles:
        wanted, lag = intent.steering_wheel_angle + motion.persistent_angle, self.muscle_time
        open_loop = demand.grip * (1.0 - demand.attention)
        remaining = open_loop * (intent.steering_wheel_angle - hand.angle) - (1.0 - open_loop) * motion.persistent_angle
        return Muscles(
            angle=motion.rate,
            rate=((wanted - motion.angle) / lag - 2.0 * motion.rate) / lag,
            persistent_angle=self.persistence * remaining,
        )


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
            target, demand.speed, first, torque - first, self.mass * acceleration, self.drive_steering * torque
        )
        return Command(angle, speed, target, time), targets

    def _wanted_angle(self, seen: Seen, demand: Demand, sensed: Sensed) -> Scalar:
        """Steering-wheel angle that follows the path [rad]."""
        reach = maximum(self.preview_time * sensed.speed, self.least_preview)
        ahead = seen.lateral_offset + self.preview_time * seen.offset_rate
        back = self.correction * demand.attention * pursuit_curvature(ahead, reach)
        curvature = demand.curvature_ahead + back
        steer = arctan(steady_road_wheel_angle(curvature, sensed.speed, self.wheelbase, self.understeer_gradient))
        steer = steer - self.yaw_feedback * demand.attention * (sensed.yaw_rate - sensed.speed * seen.curvature)
        return demand.steering_wheel_angle + steer / self.steering_ratio


class DrivingInputs(NamedTuple):
    """Inputs of a driver: motion of the vehicle, the road, and motion of the steering wheel."""

    vehicle_speed: Annotated[Scalar, "m/s"]
    lateral_speed: Annotated[Scalar, "m/s"]
    yaw_rate: Annotated[Scalar, "rad/s"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]
    road: Road
    demand: Demand


class Driven(NamedTuple):
    """Outputs of a driver, and position of the vehicle relative to its path."""

    hand_torque: Annotated[Scalar, "N*m"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    drive_force: Annotated[Scalar, "N"]
    distance: Annotated[Scalar, "m"]
    lateral_offset: Annotated[Scalar, "m"]
    heading_error: Annotated[Scalar, "rad"]


class DrivingMotion(NamedTuple):
    """Continuous states of a driver: muscles, and the motion along the path."""

    driver: Motion
    path: Path


class DrivingState(NamedTuple):
    """State of a driver between two steps."""

    motion: DrivingMotion
    driver: Memory


@dataclass(frozen=True)
class Driving:
    """Driver on a path, for a vehicle whose motion is computed elsewhere; see `Car` for the same with a virtual car."""

    driver: Driver = field(default_factory=HumanDriver)
    step_time: Annotated[float, "s", Range(1e-5, 2e-2)] = 1e-3

    Sample = DrivingInputs

    def init(self) -> DrivingState:
        return DrivingState(DrivingMotion(self.driver.init(), START), self.driver.remembered())

    def step(self, state: DrivingState, sample: DrivingInputs) -> tuple[DrivingState, Driven]:
        motion, hand = state.motion, Hand(sample.steering_wheel_angle, sample.steering_wheel_rate)
        moving = {"speed": sample.vehicle_speed, "lateral_speed": sample.lateral_speed, "yaw_rate": sample.yaw_rate}
        nothing: dict[str, Any] = dict.fromkeys(Reaction._fields, 0.0)
        reaction = Reaction(**nothing | moving)
        seen = Seen(
            sample.vehicle_speed, 0.0, sample.lateral_speed, sample.yaw_rate,
            motion.path.lateral_offset, motion.path.heading_error, sample.road.curvature, hand,
        )  # fmt: skip
        memory, intent = self.driver.decide(state.driver, seen, sample.demand)

        def slope(now: DrivingMotion) -> DrivingMotion:
            return DrivingMotion(
                self.driver.derivative(now.driver, intent, hand, sample.demand),
                path_rate(now.path, reaction, sample.road.curvature),
            )

        torque = self.driver.hand_torque(motion.driver, hand, sample.demand)
        reached = getattr(motion.driver, "angle", intent.steering_wheel_angle)
        path = motion.path
        done = Driven(torque, reached, intent.force, path.distance, path.lateral_offset, path.heading_error)
        return DrivingState(runge_kutta(slope, motion, self.step_time), memory), done
