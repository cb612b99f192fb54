"""Position control of a steering column: regulator with integral, planned motion, and a reduced observer in one block.

Source: Raffone, section 6 and Figure 10, whose regulator is "a first attempt".
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.block import Block, Scalar, Tree, map_leaves, rebuild, skeleton, values_of
from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE, check_ranges
from tierod.core.graph.maths import absolute, all_of, both, either, limit, present, tanh, where
from tierod.models.linear import LinearSystem, linearise, sampled
from tierod.models.steering_column import (
    ColumnOutput,
    ColumnParameters,
    TwoInertiaColumn,
    TwoInertiaParameters,
    without_gear,
)
from tierod.vehicles import Vehicle
from tierod_lab.papers.column.printed import PrintedObserver
from tierod_lab.papers.column.reference import ColumnMotion, Reference, advanced, motion_for


class ObservedColumn(NamedTuple):
    """Estimates of a column by an observer."""

    steering_wheel_rate: Annotated[float, "rad/s"]
    motor_speed: Annotated[float, "rad/s"]
    steering_wheel_angle: Annotated[float, "rad"]
    motor_angle: Annotated[float, "rad"]


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

    def __post_init__(self) -> None:
        check_ranges(self)


WEIGHTS: Mapping[str, float] = {"shaft": 300.0, "steering_wheel_angle": 200.0, "shaft_integral": 4.0e4}
"""Weights of the errors of shaft [1/rad^2], steering wheel [1/rad^2] and integral [1/(rad s)^2] against a motor torque
of 1 (N m)^2: three degrees of the shaft weigh as much as 1 N m. The weight of the wheel damps its oscillation on the
torsion bar. Three times the weight of the shaft would leave two thirds of the error by friction, and a tenth less
distance from instability."""
SMOOTHING = 2e-3
"""Time constant of the low-pass of the feedback [s]. It shifts the phase at the gear mode, 112 Hz in the paper's
column, so that feedback through an observer without the gear does not excite that mode."""


def regulator(
    column: TwoInertiaParameters, bar_stiffness: float, sample_time: float, weights: Mapping[str, float], kept: float
) -> tuple[ColumnGains, np.ndarray]:
    """Gains of the linear quadratic regulator of a column without gear, and the eigenvalues of the regulated column.

    Its states are those of the column, the last torque (a command acts one sample later, through the low-pass), and the
    integral of the shaft's angle.

    Args:
        bar_stiffness: stiffness between the steering wheel and the controlled shaft [N m/rad]
        weights: weights by name of state, and of the "shaft"
        kept: pole of the low-pass of the feedback
    """
    from scipy.linalg import solve_discrete_are

    names = tuple(ColumnGains.__dataclass_fields__)
    for name, weight in weights.items():
        if name not in (*names, "shaft") or not 0.0 <= weight < math.inf:
            raise ParameterError(
                f"the weight of {name} is {weight}{nearest(name, names)}; expected a number that is not negative"
            )
    whole = linearise(TwoInertiaColumn, column, (0.0,) * 4, (0.0,) * 3)
    share = column.stiffness / bar_stiffness
    row = np.array([0.0, 0.0, 1.0 - share, share / column.motor_ratio])
    plant = sampled(LinearSystem.of(whole.A, row[None, :], whole.B[:, :1]), sample_time)
    A, B = np.eye(6), np.zeros((6, 1))
    A[:4, :4], A[:4, 4:5], A[4, 4], A[5, :4] = plant.A, plant.B, kept, sample_time * row
    B[4] = 1.0 - kept
    Q = np.diag([weights.get(name, 0.0) for name in names])
    Q[:4, :4] += weights.get("shaft", 0.0) * np.outer(row, row)
    try:
        cost = solve_discrete_are(A, B, Q, np.eye(1))
    except (np.linalg.LinAlgError, ValueError) as error:
        raise ParameterError(f"no regulator was found ({error}); give weights of like size") from None
    gain = np.linalg.solve(np.eye(1) + B.T @ cost @ B, B.T @ cost @ A)
    eigenvalues = np.linalg.eigvals(A - B @ gain)
    if not np.abs(eigenvalues).max() < 1.0 - 1e-9:
        raise ParameterError(
            "the regulated column keeps an error that does not decay; weigh the shaft and its integral"
        )
    return ColumnGains(*map(float, gain[0])), eigenvalues


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
    # level of dry friction at the motor for feed-forward in the direction of the planned motion; zero for none
    friction: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    # planned motor speed below which the friction torque is about proportional to it, for a smooth reversal
    friction_speed: Annotated[float, "rad/s", POSITIVE] = 0.5

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
        check_ranges(self)

    @classmethod
    def design(
        cls,
        column: TwoInertiaParameters,
        torsion_bar_stiffness: float,
        sample_time: float = 1e-3,
        weights: Mapping[str, float] = WEIGHTS,
        smoothing: float = SMOOTHING,
        **settings: Any,
    ) -> PositionControl:
        """Design the position control of a column.

        Args:
            torsion_bar_stiffness: stiffness between the steering wheel and the controlled shaft [N m/rad]
            sample_time: sampling interval [s]
            weights: weights of states and of the "shaft" against 1 (N m)^2
            smoothing: time constant of the low-pass of the feedback [s]
            settings: further fields, such as `friction` and `limits`
        """
        for name in ("steering_wheel_inertia", "motor_inertia", "stiffness", "motor_ratio"):
            if not getattr(column, name) > 0.0:
                raise ParameterError(f"{name} is {getattr(column, name)}; expected a number above zero")
        for name, value in {"torsion_bar_stiffness": torsion_bar_stiffness, "smoothing": smoothing}.items():
            if not 0.0 < value < math.inf:
                raise ParameterError(f"{name} is {value}; expected a number above zero")
        kept = math.exp(-sample_time / smoothing)
        gains, _ = regulator(column, torsion_bar_stiffness, sample_time, weights, kept)
        return cls(gains, column, torsion_bar_stiffness, sample_time=sample_time, kept=kept, **settings)

    def init(self) -> State:
        return self.State(0.0, 0.0, 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        usable = all_of(*(present(value) for value in values_of(sample)))
        # A missing input counts as zero, so that no NaN enters the state.
        given: Any = map_leaves(lambda value: where(usable, value, 0.0), sample)
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
        # The last command was planned 1.5 samples ahead of the last sample, that is 0.5 samples ahead of this one.
        aside = state.torque - self._planned_torque(given.reference, 0.5 * self.sample_time)
        feedback = (
            gains.steering_wheel_rate * (observed.steering_wheel_rate - planned.steering_wheel_rate)
            + gains.motor_speed * (observed.motor_speed - planned.motor_speed)
            + gains.steering_wheel_angle * (observed.steering_wheel_angle - planned.steering_wheel_angle)
            + gains.motor_angle * (observed.motor_angle - planned.motor_angle)
            + gains.previous_motor_torque * aside
            + gains.shaft_integral * state.integral
        )
        ahead = self._planned_torque(given.reference, 1.5 * self.sample_time)
        return ahead + self.kept * aside - (1.0 - self.kept) * feedback

    def _planned_torque(self, reference: Reference, ahead: Scalar) -> Scalar:
        motion = motion_for(advanced(reference, ahead), self.column, self.output_stiffness)
        return motion.motor_torque + self.friction * tanh(motion.motor_speed / self.friction_speed)


@dataclass(frozen=True)
class ObservedPositionControl:
    """Position control on the estimates of an observer: from measurements and reference to the torque of the motor."""

    observer: Block  # block whose sample is the motor torque and the measurements
    control: PositionControl

    class Sample(NamedTuple):
        measured: ColumnOutput
        reference: Reference
        enabled: Annotated[float, ""]

    class State(NamedTuple):
        """States of observer and control; the torque that acts, and the one that acted before."""

        observer: Tree
        control: PositionControl.State
        acting: Scalar
        acted: Scalar

    class Output(NamedTuple):
        motor_torque: Annotated[float, "N*m"]  # command to the motor, which acts from the next sample on
        hand_torque: Annotated[float, "N*m"]
        observed: ObservedColumn
        control: PositionControl.Output

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sample_time: float = 1e-3) -> ObservedPositionControl:
        """The control of a vehicle's column on the paper's observer of its mechanical reduction."""
        column = vehicle.parameters_for(ColumnParameters)
        observer = PrintedObserver.of_column(column, "series spring", sample_time)
        return cls.with_observer(observer, column, vehicle["motor_friction"], sample_time)

    @classmethod
    def with_observer(
        cls, observer: Block, column: ColumnParameters, friction: float, sample_time: float = 1e-3
    ) -> ObservedPositionControl:
        """The control on another observer, with a dry friction at the motor that is fed forward [N m]."""
        reduced, bar = without_gear(column), column.torsion_bar_stiffness
        return cls(observer, PositionControl.design(reduced, bar, sample_time, friction=friction))

    def init(self) -> State:
        return self.State(self.observer.init(), self.control.init(), 0.0, 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        # The observer receives the torque that acted until its sample.
        given = rebuild(skeleton(self.observer.Sample), [state.acted, *sample.measured])
        observer, estimate = self.observer.step(state.observer, given)
        named: Tree = getattr(estimate, "mean", estimate)
        motor = named.motor_angle if hasattr(named, "motor_angle") else named.motor_angle_mechanical
        observed = ObservedColumn(named.steering_wheel_rate, named.motor_speed, named.steering_wheel_angle, motor)
        asked = PositionControl.Sample(observed, sample.reference, sample.enabled)
        control, found = self.control.step(state.control, asked)
        after = self.State(observer, control, found.motor_torque, state.acting)
        return after, self.Output(found.motor_torque, named.hand_torque, observed, found)
