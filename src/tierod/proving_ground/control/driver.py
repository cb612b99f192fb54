"""The person who drives: follows a road with eyes, arms and a foot."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Ring, Scalar
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.core.graph.maths import absolute, arctan, both, limit, maximum, minimum, where
from tierod.physics.planar_motion import pursuit_curvature
from tierod.physics.single_track import steady_road_wheel_angle
from tierod.proving_ground.parts import Demand, Hand, Intent, Seen

STANDING = 0.02
"""Speed below which a car counts as standing [m/s]."""


class Foot(NamedTuple):
    """State of the foot, as accelerations [m/s**2].

    Args:
        learnt: what gradients and drag have asked for
        pressed: what is pressed now
        resting: least braking of a halting car, which grows until it stands
    """

    learnt: Scalar
    pressed: Scalar
    resting: Scalar


@dataclass(frozen=True)
class Pedals:
    """Keeps a target speed: its planned acceleration ahead, proportional and integral action on the speed error.

    With the defaults the closed loop has both poles near -0.5 1/s. The slower the car, the lighter the foot brakes: a
    stop is eased, since the tyres throw a car back that is stopped at once. Where the target is zero and the car has
    almost stopped, the foot rests on the brake until the target rises.

    Args:
        proportional: acceleration per speed error
        integral: growth of acceleration per speed error
        learnt_limit: of what the integral can reach: a gradient of 20 %, drag at high speed
        foot_time: lag of the foot
        strongest_acceleration, strongest_braking: what is asked for at the most
        easing_speed: below it braking becomes the lighter
        last_share: of the braking that is left at the end of a stop
        holding: deceleration that would result from the brake's force at rest
        resting_speed: below it, the target at zero, the foot comes to rest on the brake
        resting_rate: at which its weight grows while the car still rolls
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
        """At ease."""
        return Foot(0.0, 0.0, 0.0)

    def press(
        self, foot: Foot, speed: Scalar, wanted_speed: Scalar, planned: Scalar, step: Scalar
    ) -> tuple[Foot, Scalar]:
        """Once a step: the foot afterwards, and the acceleration [m/s**2] that it commands.

        Args:
            foot: before
            speed: forward speed [m/s]
            wanted_speed: target [m/s]
            planned: acceleration of the target [m/s**2]
            step: [s]
        """
        error = wanted_speed - speed
        asked = self._eased(planned + self.proportional * error, speed) + foot.learnt
        wanted = limit(asked, -self.strongest_braking, self.strongest_acceleration)
        halting = both(wanted_speed < 0.5 * self.resting_speed, speed < self.resting_speed)
        resting = where(halting, self._resting(foot, speed, step), 0.0)
        wanted = where(halting, minimum(wanted, -resting), wanted)
        learning = where(both(wanted == asked, speed >= self.resting_speed), self.integral * error, 0.0)
        learnt = limit(foot.learnt + step * learning, -self.learnt_limit, self.learnt_limit)
        pressed = foot.pressed + step / self.foot_time * (wanted - foot.pressed)
        return Foot(learnt, pressed, resting), pressed

    def _eased(self, acceleration: Scalar, speed: Scalar) -> Scalar:
        """Braking at walking pace becomes lighter; anything else stays [m/s**2]."""
        share = self.last_share + (1.0 - self.last_share) * limit(speed / self.easing_speed, 0.0, 1.0)
        return where(acceleration < 0.0, share * acceleration, acceleration)

    def _resting(self, foot: Foot, speed: Scalar, step: Scalar) -> Scalar:
        """Weight of the foot on the brake [m/s**2]: all of it at rest, growing until then."""
        growing = minimum(foot.resting + step * self.resting_rate, self.holding)
        return where(speed < STANDING, self.holding, growing)


class Muscles(NamedTuple):
    """State of the arms' differential equations: angle of the muscles, its rate, and patience [rad], ..."""

    angle: Scalar
    rate: Scalar
    persistent_angle: Scalar


class Mind(NamedTuple):
    """State of a driver: offsets not yet reacted to, curvature that is being steered, and the foot."""

    offset_ahead: Ring
    curvature: Scalar
    foot: Foot


@dataclass(frozen=True)
class HumanDriver:
    """A person who previews the road's curvature, corrects the offset after a delay, and steers with arms.

    The arms are a spring and damper that pull the wheel towards an angle the muscles have reached; the muscles follow
    the wanted angle with a lag of second order, critically damped. After Pick and Cole, Vehicle System Dynamics 46
    (2008). The person assumes four numbers of their own for a car, which need not be those of the car.

    Args:
        mass: assumed, of the car
        wheelbase: assumed
        understeer_gradient: assumed, extra road-wheel angle per lateral acceleration
        rear_distance: assumed, from the centre of gravity to the rear axle; a car's middle turns in before its rear
        steering_ratio: assumed, road-wheel angle per steering-wheel angle
        arm_stiffness: torque per angle between muscles and wheel
        arm_damping: torque per rate between muscles and wheel
        muscle_time: time constant of the muscles, twice in a row
        torque_limit: what the person can or will apply
        preview_time: how far ahead the offset from the road is judged
        anticipation: how early the road's curvature is steered, makes up for muscles and vehicle
        correction: share of the offset correction that the person makes with full attention
        greatest_offset: an offset beyond it is corrected no faster
        expected_effort: assumed torque at the steering wheel per lateral acceleration, which the arms press in advance
        persistence: integral gain on the remaining angle error, for a person who has to reach an angle (no attention to
            a lane, hands on the wheel)
        slowest_correction: speed below which the offset is corrected the less, not at all at rest
        pedals: speed keeping
        step_time: between two decisions
        delay_steps: reaction delay of the correction, in steps
    """

    mass: Annotated[float, "kg", POSITIVE] = 1600.0
    wheelbase: Annotated[float, "m", POSITIVE] = 2.83
    understeer_gradient: Annotated[float, "rad*s**2/m", ANY] = 3.73e-3
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
    persistence: Annotated[float, "1/s", NOT_NEGATIVE] = 3.0
    slowest_correction: Annotated[float, "m/s", POSITIVE] = 3.0
    pedals: Pedals = field(default_factory=Pedals)
    step_time: Annotated[float, "s", POSITIVE] = 1e-3
    delay_steps: int = 150

    def init(self) -> Muscles:
        """Muscles relaxed, straight ahead."""
        return Muscles(0.0, 0.0, 0.0)

    def remembered(self) -> Mind:
        """Nothing seen yet."""
        return Mind(Ring(self.delay_steps), 0.0, self.pedals.remembered())

    def decide(self, memory: Mind, seen: Seen, demand: Demand) -> tuple[Mind, Intent]:
        """Once a step: judge what is seen, after the reaction time.

        Args:
            memory: of the step before
            seen: at this instant
            demand: of the course
        """
        foot, acceleration = self.pedals.press(
            memory.foot, seen.speed, demand.speed, demand.acceleration, self.step_time
        )
        attention = demand.attention * limit(seen.speed / self.slowest_correction, 0.0, 1.0)
        offset = memory.offset_ahead.oldest
        gone = minimum(absolute(seen.speed) * self.step_time / self.rear_distance, 1.0)
        ahead = memory.curvature + gone * (demand.curvature_ahead - memory.curvature)
        curvature = ahead + self._correcting(attention * offset, seen.speed)
        steer = arctan(steady_road_wheel_angle(curvature, seen.speed, self.wheelbase, self.understeer_gradient))
        pressed = self.expected_effort * seen.speed * seen.speed * ahead / self.arm_stiffness
        wanted = demand.steering_wheel_angle + steer / self.steering_ratio + pressed
        near = limit(seen.lateral_offset, -self.greatest_offset, self.greatest_offset)
        noticed = memory.offset_ahead.push(near + self.preview_time * seen.offset_rate)
        return Mind(noticed, ahead, foot), Intent(wanted, self.mass * acceleration)

    def _correcting(self, offset_ahead: Scalar, speed: Scalar) -> Scalar:
        """Curvature [1/m] that would lead back to the path over the preview distance."""
        reach = self.preview_time * maximum(speed, self.slowest_correction)
        return self.correction * pursuit_curvature(offset_ahead, reach)

    def hand_torque(self, motion: Muscles, hand: Hand, demand: Demand) -> Scalar:
        """Torque of the hands on the steering wheel [N*m].

        Args:
            motion: of the muscles
            hand: angle and rate of the steering wheel
            demand: of the course: grip, and torque added to that of the arms
        """
        arms = self.arm_stiffness * (motion.angle - hand.angle) + self.arm_damping * (motion.rate - hand.rate)
        return limit(demand.grip * arms, -self.torque_limit, self.torque_limit) + demand.hand_torque

    def derivative(self, motion: Muscles, intent: Intent, hand: Hand, demand: Demand) -> Muscles:
        """Rate of change of the muscles and of the persistent angle.

        Args:
            motion: of the muscles
            intent: from `decide`
            hand: angle and rate of the steering wheel
            demand: of the course: grip and attention
        """
        wanted, lag = intent.steering_wheel_angle + motion.persistent_angle, self.muscle_time
        open_loop = demand.grip * (1.0 - demand.attention)
        remaining = open_loop * (intent.steering_wheel_angle - hand.angle) - (1.0 - open_loop) * motion.persistent_angle
        return Muscles(
            angle=motion.rate,
            rate=((wanted - motion.angle) / lag - 2.0 * motion.rate) / lag,
            persistent_angle=self.persistence * remaining,
        )
