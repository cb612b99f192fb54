"""Position control of a steering column by state feedback on observed states, integral action and feed-forward."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple, TypedDict, Unpack

from tierod.core.block import Scalar, Tree, Truth, map_leaves, values_of
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE, numbers
from tierod.core.graph.maths import absolute, all_of, both, either, limit, present, tanh, where
from tierod.models.steering_column import TwoInertiaParameters
from tierod_lab.papers.column.control.lqr import SMOOTHING, kept_share, regulator
from tierod_lab.papers.column.control.reference import ColumnMotion, Reference, advanced, motion_for


class ObservedColumn(NamedTuple):
    """Estimates of a column by an observer."""

    # steering_wheel_rate, motor_speed, steering_wheel_angle, motor_angle: the state
    steering_wheel_rate: Annotated[float, "rad/s"]
    motor_speed: Annotated[float, "rad/s"]
    steering_wheel_angle: Annotated[float, "rad"]
    motor_angle: Annotated[float, "rad"]
    # torque that opposes the motor at its shaft: dry friction, torque from the rack
    disturbance_torque: Annotated[float, "N*m"]


@dataclass(frozen=True)
class ColumnGains:
    """Feedback gains K: motor torque per deviation of each state from the planned motion."""

    steering_wheel_rate: Annotated[float, "N*m*s/rad"]
    motor_speed: Annotated[float, "N*m*s/rad"]
    steering_wheel_angle: Annotated[float, "N*m/rad"]
    motor_angle: Annotated[float, "N*m/rad"]
    previous_motor_torque: Annotated[float, ""]
    shaft_integral: Annotated[float, "N*m/rad/s"]


@dataclass(frozen=True)
class TorqueLimits:
    """Limits of the commanded motor torque, and times of engagement and release."""

    # largest torque at the motor shaft; 3 N m are 54 N m at the steering wheel axis behind a ratio of 18, an electric
    # power steering of the middle class
    torque: Annotated[float, "N*m", POSITIVE] = 3.0
    # largest rate of the torque; from zero to full torque in 20 ms it protects the gear, and the sweep needs a fifth of
    # it
    rate: Annotated[float, "N*m/s", POSITIVE] = 150.0
    # time of engagement, slow enough for an unnoticed takeover of the wheel
    engaging: Annotated[float, "s", POSITIVE] = 0.3
    # time of release, much shorter than a driver's push, yet without a jerk
    releasing: Annotated[float, "s", POSITIVE] = 0.1


class Settings(TypedDict, total=False):
    """Fields of a `PositionControl` that its design does not determine."""

    limits: TorqueLimits
    feed_forward: float
    friction: float
    friction_speed: float
    disturbance_compensation: float


@dataclass(frozen=True)
class PositionControl:
    """Position control of the output shaft of a column: planned torque, state feedback, integral action.

    torque = plan + friction - K (state - planned state) - K_i integral(shaft - reference), within the torque limits.
    The plan looks 1.5 samples ahead, since the torque acts one sample later and for one sample. The integral is frozen
    during engagement, and while a limit is active and it would push further into it, so that it cannot wind up. Without
    `enabled`, or with a missing input, the torque is released within `limits.releasing`. At engagement the torque
    begins at zero for any state.
    """

    gains: ColumnGains  # gains of the state feedback, from `design`
    column: TwoInertiaParameters  # assumed parameters of the column
    # stiffness between the steering wheel and the controlled shaft [N m/rad]
    output_stiffness: Annotated[float, "N*m/rad", POSITIVE]
    limits: TorqueLimits = field(default_factory=TorqueLimits)  # limits of the torque
    sample_time: Annotated[float, "s", POSITIVE] = 1e-3  # sampling interval [s]
    # pole of a first-order low-pass on the deviation of the torque from the plan, which keeps the feedback from
    # exciting the gear mode; the design includes it
    kept: Annotated[float, "", SHARE] = 0.0
    feed_forward: Annotated[float, "", SHARE] = 1.0  # share of the planned torque that is used
    # level of dry friction at the motor for feed-forward in the direction of the planned motion; zero for none
    friction: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    # planned motor speed below which the friction torque is about proportional to it, for a smooth reversal
    friction_speed: Annotated[float, "rad/s", POSITIVE] = 0.5
    # share of the observed disturbance torque that is compensated. It is a second integral action, faster than the
    # first, and costs margin: full compensation halves the distance from instability
    disturbance_compensation: Annotated[float, "", SHARE] = 0.0

    class Sample(NamedTuple):
        observed: ObservedColumn
        reference: Reference
        enabled: Annotated[float, ""]

    class State(NamedTuple):
        torque: float
        integral: float
        hold: float

    class Output(NamedTuple):
        """Commanded motor torque, observed shaft angle, and internal quantities of the control."""

        motor_torque: Annotated[float, "N*m"]  # command to the motor
        shaft_angle: Annotated[float, "rad"]  # observed angle of the shaft
        error: Annotated[float, "rad"]  # observed less reference angle of the shaft
        limited: Annotated[float, ""]  # whether a limit of the torque or of its rate is active (1.0 or 0.0)
        hold: Annotated[float, ""]  # degree of engagement, 0 released to 1 in full control
        planned: ColumnMotion  # planned motion for the reference

    def __post_init__(self) -> None:
        for name, number in numbers(self).items():
            if number.limits and not number.limits.holds(number.value):
                raise ParameterError(f"{name} is {number.value} {number.unit}; expected {number.limits}")

    @classmethod
    def design(
        cls,
        column: TwoInertiaParameters,
        torsion_bar_stiffness: float,
        sample_time: float = 1e-3,
        weights: Mapping[str, float] | None = None,
        torque_weight: float = 1.0,
        smoothing: float = SMOOTHING,
        **settings: Unpack[Settings],
    ) -> PositionControl:
        """Design the position control of a column.

        Args:
            torsion_bar_stiffness: stiffness between the steering wheel and the controlled shaft [N m/rad]
            sample_time: sampling interval [s]
            weights: weights of states and of the `shaft`, as in `lqr`; `WEIGHTS` where None
            torque_weight: weight of the motor torque, 1/(N m)^2
            smoothing: time constant of the low-pass of the feedback, 0 for none [s]

        Raises:
            ParameterError: as in `lqr`, for the column with its integral and its delay of one sample
        """
        found = regulator(column, torsion_bar_stiffness, sample_time, weights, torque_weight, smoothing)
        gains = ColumnGains(*(found.of(state) for state in found.system.states))
        kept = kept_share(smoothing, sample_time)
        return cls(gains, column, torsion_bar_stiffness, sample_time=sample_time, kept=kept, **settings)

    def init(self) -> State:
        return self.State(0.0, 0.0, 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        usable = all_of(*(present(value) for value in values_of(sample)))
        given = self.Sample(*_kept(usable, (sample.observed, sample.reference, sample.enabled)))
        wants = both(usable, given.enabled > 0.5)
        planned = motion_for(given.reference, self.column, self.output_stiffness)
        shaft = self.shaft_angle(given.observed)
        error = shaft - given.reference.angle
        grows, falls = self.sample_time / self.limits.engaging, self.sample_time / self.limits.releasing
        hold = limit(state.hold + where(wants, grows, -falls), 0.0, 1.0)
        asked = self._torque(state, given, planned)
        held = limit(asked, -self.limits.torque, self.limits.torque)
        most = self.limits.rate * self.sample_time
        torque = limit(hold * held, state.torque - most, state.torque + most)
        limited = absolute(hold * asked - torque) > 1e-9 * self.limits.torque
        # The integral acts with a negative sign: it pushes further into the limit where the error and the torque that
        # the limit cuts off have opposite signs.
        blocked = either(hold < 1.0, both(limited, error * (hold * asked - torque) < 0.0))
        integral = where(blocked, state.integral, state.integral + self.sample_time * error)
        after = self.State(torque, where(hold > 0.0, integral, 0.0), hold)
        return after, self.Output(torque, shaft, error, where(limited, 1.0, 0.0), hold, planned)

    def shaft_angle(self, observed: ObservedColumn) -> Scalar:
        """Angle of the controlled shaft [rad], interpolated between motor and steering wheel by the two stiffnesses."""
        motor = observed.motor_angle / self.column.motor_ratio
        share = self.column.stiffness / self.output_stiffness
        return observed.steering_wheel_angle + share * (motor - observed.steering_wheel_angle)

    def _torque(self, state: State, given: Sample, planned: ColumnMotion) -> Scalar:
        """Torque of plan, feedback and integral before the limits [N m]."""
        gains, observed = self.gains, given.observed
        compensation = self.disturbance_compensation * observed.disturbance_torque
        # The last command was planned 1.5 samples ahead of the last sample, that is 0.5 samples ahead of this one.
        aside = state.torque - self._planned_torque(given.reference, 0.5 * self.sample_time) - compensation
        feedback = (
            gains.steering_wheel_rate * (observed.steering_wheel_rate - planned.steering_wheel_rate)
            + gains.motor_speed * (observed.motor_speed - planned.motor_speed)
            + gains.steering_wheel_angle * (observed.steering_wheel_angle - planned.steering_wheel_angle)
            + gains.motor_angle * (observed.motor_angle - planned.motor_angle)
            + gains.previous_motor_torque * aside
            + gains.shaft_integral * state.integral
        )
        ahead = self._planned_torque(given.reference, 1.5 * self.sample_time) + compensation
        return ahead + self.kept * aside - (1.0 - self.kept) * feedback

    def _planned_torque(self, reference: Reference, ahead: Scalar) -> Scalar:
        motion = motion_for(advanced(reference, ahead), self.column, self.output_stiffness)
        rubbing = self.friction * tanh(motion.motor_speed / self.friction_speed)
        return self.feed_forward * (motion.motor_torque + rubbing)


def _kept(usable: Truth, trees: tuple[Tree, ...]) -> tuple[Tree, ...]:
    """The trees, or zeros where an input is missing, so that no NaN enters the state."""
    return tuple(map_leaves(lambda value: where(usable, value, 0.0), tree) for tree in trees)
