"""All residuals of the sensors, r1 to r19, as one block."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import POSITIVE
from tierod.core.graph.maths import absolute, all_of, both, maximum, minimum, present, select, where
from tierod.methods.estimators import KalmanFilter
from tierod.methods.estimators.shapes import Belief
from tierod.methods.filters import InputHold
from tierod.models.single_track import SingleTrack
from tierod.monitors.condition.signals import ConditionSample, Measured
from tierod_lab.methods.unscented import UnscentedFilter
from tierod_lab.papers.condition.rules.adaptive_speed import AdaptiveSpeed
from tierod_lab.papers.condition.rules.angle_filters import one_body
from tierod_lab.papers.condition.rules.equations import Equations
from tierod_lab.papers.condition.rules.parameters import SENSOR_RESIDUALS, Coefficients, ResidualParameters
from tierod_lab.papers.condition.rules.rack import StiffRack
from tierod_lab.papers.condition.rules.readings import Excitation, Motion, SensorFlags, SensorResiduals
from tierod_lab.papers.condition.rules.routes import lateral_filter
from tierod_lab.papers.condition.rules.steering_signals import Smooth, SteeringSignals


@dataclass(frozen=True)
class ResidualSet:
    """Residuals r1 to r19 at every sample, each with a flag for its presence.

    Args:
        coefficients: coefficients of `calibrate_residuals`
        steering: low-passes and derivatives of the signals of the steering
        angle: filter of r1; as in the paper it measures the angle, so that it follows a faulty sensor after a jump
        moving: speed of the faster rear wheel below which the vehicle counts as standing
        most_lateral_acceleration: limit above which residuals of the single-track model are disabled, as its tyres are
            linear
        settling: time for which a signal must have been present before its residuals are enabled, as filters restart
        printed: whether eqs (9), (11), (14), (27) and (46) keep their misprints
        copied: whether a filter of two bodies gets the rack position as rack ratio times angle (eq 5)

    Build it by `residual_set`.
    """

    car: ResidualParameters
    coefficients: Coefficients
    hold: InputHold
    steering: SteeringSignals
    angle: UnscentedFilter
    lateral: KalmanFilter
    speed: AdaptiveSpeed
    moving: Annotated[float, "m/s", POSITIVE] = 1.5
    most_lateral_acceleration: Annotated[float, "m/s**2", POSITIVE] = 6.0
    settling: Annotated[float, "s", POSITIVE] = 1.0
    printed: bool = False
    copied: bool = False

    Sample = ConditionSample

    class State(NamedTuple):
        hold: Tree
        steering: tuple[Smooth, ...]
        angle: Belief
        unmeasured: Tree
        lateral: Belief
        speed: AdaptiveSpeed.State
        there: Measured

    class Output(NamedTuple):
        residuals: SensorResiduals
        there: SensorFlags
        motion: Motion
        held: Measured
        excitation: Excitation

    def init(self) -> State:
        return self.State(
            self.hold.init(),
            self.steering.init(),
            self.angle.init(),
            self.angle.init().mean,
            self.lateral.init(),
            self.speed.init(),
            Measured(*(0.0,) * len(Measured._fields)),
        )

    def step(self, state: State, sample: ConditionSample) -> tuple[State, Output]:
        hold, held = self.hold.step(state.hold, Measured(*(getattr(sample, name) for name in Measured._fields)))
        # Zeros in place of NaN keep the state finite; the flags exclude the residuals of missing signals.
        now = Measured(*(where(present(value), value, 0.0) for value in held))
        left, right = now.wheel_speed_rear_left, now.wheel_speed_rear_right
        moving = maximum(left, right) > self.moving
        balance = self.steering.Sample(
            held.steering_wheel_angle, held.steering_shaft_torque, held.tie_rod_force, held.lateral_acceleration
        )
        steering, steer = self.steering.step(state.steering, balance)
        angle, by_balance = self._balanced(state.angle, held)
        unmeasured = self._unmeasured(state.unmeasured, held)
        lateral, turning = self._turning(state.lateral, held, now)
        speed, forward = self.speed.step(
            state.speed,
            AdaptiveSpeed.Sample(held.longitudinal_acceleration, held.yaw_rate, turning.sideslip_angle, *held[:2]),
        )
        equations = Equations(self.car, self.coefficients, self.moving, self.printed)
        expected = equations.expected(now, steer, turning, forward, unmeasured.steering_wheel_angle)
        values = equations.residuals(now, steer, by_balance, turning, forward, expected)
        waited = Measured(*(self._waited(*each) for each in zip(state.there, held, strict=True)))
        there = self._there(waited, held, moving)
        values = SensorResiduals(*(where(flag, value, 0.0) for flag, value in zip(there, values, strict=True)))
        after = self.State(hold, steering, angle, unmeasured, lateral, speed, waited)
        excitation = self._excitation(now, steer, turning, forward)
        return after, self.Output(values, there, expected, held, excitation)

    def _excitation(
        self, now: Measured, steer: SteeringSignals.Output, turning: SingleTrack.State, forward: AdaptiveSpeed.Output
    ) -> Excitation:
        """Excitation of the drive, mostly by the estimates of filters, which a single faulty sensor disturbs less."""
        speed = maximum(forward.forward_speed, self.moving)
        inputs = SingleTrack.Input(self.car.steering_ratio * steer.angle, speed)
        slope = SingleTrack.derivative(turning, inputs, self.car.single_track)
        return Excitation(forward.forward_speed, slope.yaw_rate, now.lateral_acceleration, steer.rate)

    def _waited(self, before: Scalar, value: Scalar) -> Scalar:
        """Time for which a signal has been present [s], limited to twice `settling`."""
        waited: Scalar = minimum(before + self.hold.sample_time, 2.0 * self.settling)
        return where(present(value), waited, 0.0)

    def _there(self, waited: Measured, held: Measured, moving: Scalar) -> SensorFlags:
        """Whether all signals of each residual are present and its enabling conditions hold, 1.0 or 0.0."""
        known = {name: each > self.settling for name, each in waited._asdict().items()}
        across = where(present(held.lateral_acceleration), held.lateral_acceleration, 0.0)
        gentle = absolute(across) < self.most_lateral_acceleration
        flags = []
        for each in SENSOR_RESIDUALS:
            asked = [known[name] for name in each.signals]
            asked += ([moving] if each.moving else []) + ([gentle] if each.gentle else [])
            flags.append(where(all_of(*asked), 1.0, 0.0))
        return SensorFlags(*flags)

    def _balanced(self, state: Belief, held: Measured) -> tuple[Belief, Scalar]:
        """Advances the filter of r1 by one sample; returns its state and the estimated angle [rad]."""
        inputs = StiffRack.Input(held.steering_shaft_torque, held.tie_rod_force)
        shape = self.angle.model.Output
        copied = self.car.rack_ratio * held.steering_wheel_angle if self.copied else math.inf  # not present
        rack = {"rack_position": copied} if "rack_position" in shape._fields else {}
        measured = shape(**rack, steering_wheel_angle=held.steering_wheel_angle)
        after, estimate = self.angle.step(state, self.angle.Sample(inputs, measured))
        return after, estimate.mean.steering_wheel_angle

    def _unmeasured(self, state: Tree, held: Measured) -> Tree:
        """State of the steering predicted from torque and force alone; held while one of them is missing."""
        complete = both(present(held.steering_shaft_torque), present(held.tie_rod_force))
        inputs = StiffRack.Input(
            where(complete, held.steering_shaft_torque, 0.0), where(complete, held.tie_rod_force, 0.0)
        )
        ahead = self.angle.model.transition(state, inputs, self.angle.parameters)
        return select(complete, ahead, state)

    def _turning(self, state: Belief, held: Measured, now: Measured) -> tuple[Belief, SingleTrack.State]:
        """Advances the lateral filter by one sample; its speed is the mean of the rear wheels, limited from below."""
        speed = maximum(0.5 * (now.wheel_speed_rear_left + now.wheel_speed_rear_right), self.moving)
        steer = self.car.steering_ratio * (held.steering_wheel_angle - self.coefficients.angle_offset)
        after, estimate = self.lateral.step(
            state,
            self.lateral.Sample(
                SingleTrack.Input(steer, speed), SingleTrack.Output(held.yaw_rate, held.lateral_acceleration)
            ),
        )
        return after, estimate.mean


def residual_set(
    car: ResidualParameters,
    coefficients: Coefficients | None = None,
    sample_time: float = 0.01,
    printed: bool = False,
    angle: UnscentedFilter | None = None,
    copied: bool = False,
) -> ResidualSet:
    """The residuals of a vehicle.

    Args:
        coefficients: coefficients of a calibration; zeros where None, which leaves r3 and r19 without a model
        sample_time: sampling interval [s]
        angle: filter of r1 from `angle_filters`; that of one body if None
        copied: whether a filter of two bodies gets the rack position by eq (5)
    """
    return ResidualSet(
        car,
        coefficients or Coefficients(),
        InputHold(Measured, sample_time, 2.0 * sample_time),
        SteeringSignals(sample_time=sample_time),
        angle or one_body(car, sample_time),
        lateral_filter(car.single_track, sample_time, printed),
        AdaptiveSpeed.design(car.track_width, sample_time),
        printed=printed,
        copied=copied,
    )
