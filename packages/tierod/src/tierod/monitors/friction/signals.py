"""Signals that friction monitors read, their conditioning, and the gate that selects samples with information."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, leaves, map_leaves, rebuild, values_of
from tierod.core.graph.maths import absolute, all_of, limit, minimum, present, where
from tierod.methods.filters import Butterworth, InputHold
from tierod.physics.friction import share_reached


class SteeringSample(NamedTuple):
    """Seven signals of one sample, with the vehicle speed; NaN where one is missing."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    driver_torque: Annotated[float, "N*m"]
    motor_torque: Annotated[float, "N*m"]
    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    vehicle_speed: Annotated[float, "m/s"]


class GateConditions(NamedTuple):
    """Conditions of the gate one by one, so that a verdict can name the one that kept it closed.

    `rolling` is the Python value True where no minimum speed is set.
    """

    hands_on: Scalar
    same_direction: Scalar
    moving: Scalar
    not_too_fast: Scalar
    rolling: Scalar


@dataclass(frozen=True)
class FrictionGate:
    """Gate that opens while driver and motor steer in the same direction, neither too slowly nor too fast.

    `minimum_rate` must stay well above the noise of the rate, or noise decides the sign of friction: in simulation a
    noise of 0.05 rad/s costs 0.4 to 1.5 N m. Hands off, active return and lane keeping break the condition on the signs
    of the torques; the gate then indicates little.

    Args:
        minimum_driver_torque: driver's torque above which the assist is active [N m]; 0.5 as printed
        maximum_rate: rate up to which the filter can follow [rad/s]; 1 as printed (scan: "0.1rads")
        minimum_speed: lowest speed of the vehicle [m/s]; None leaves the condition out, as printed. About 3: below it
            tyre scrub is not a self-aligning torque

    Source: Mohtat et al., eq (14).
    """

    minimum_driver_torque: Annotated[float, "N*m"] = 0.5
    minimum_rate: Annotated[float, "rad/s"] = 0.05  # rate above which friction has a direction [rad/s]; 0.05 as printed
    maximum_rate: Annotated[float, "rad/s"] = 1.0
    minimum_speed: Annotated[float, "m/s"] | None = None

    def opened(
        self, driver_torque: Scalar, motor_torque: Scalar, steering_wheel_rate: Scalar, vehicle_speed: Scalar = 0.0
    ) -> Scalar:
        """Whether the sample enables the estimate of friction; a missing signal closes the gate."""
        *worked, rolling = self.conditions(driver_torque, motor_torque, steering_wheel_rate, vehicle_speed)
        return all_of(*worked) if rolling is True else all_of(*worked, rolling)

    def conditions(
        self, driver_torque: Scalar, motor_torque: Scalar, steering_wheel_rate: Scalar, vehicle_speed: Scalar = 0.0
    ) -> GateConditions:
        rate = absolute(steering_wheel_rate)
        return GateConditions(
            hands_on=absolute(driver_torque) > self.minimum_driver_torque,
            same_direction=driver_torque * motor_torque > 0.0,
            moving=self.minimum_rate < rate,
            not_too_fast=rate < self.maximum_rate,
            rolling=True if self.minimum_speed is None else vehicle_speed > self.minimum_speed,
        )


_LARGEST = 1e6  # above any steering signal, calibrated or not: a fault of the recording, treated as missing

SAMPLE_TIME = 0.01  # Time between two samples [s]: 10 ms as printed by Mohtat et al., section 3.2


class ConditionedSteering(NamedTuple):
    """Signals without gaps, all with the same delay."""

    signals: SteeringSample  # held and low-passed signals, never missing
    angle_increment: Annotated[float, "rad"]  # increment of the steering wheel angle since the previous sample
    # steering_wheel_acceleration, yaw_acceleration, vehicle_acceleration: backward differences of the low-passed rates
    # and speed
    steering_wheel_acceleration: Annotated[float, "rad/s**2"]
    yaw_acceleration: Annotated[float, "rad/s**2"]
    vehicle_acceleration: Annotated[float, "m/s**2"]
    # driver_torque_rate, driver_torque_acceleration: first and second backward difference of the low-passed torque
    driver_torque_rate: Annotated[float, "N*m/s"]
    driver_torque_acceleration: Annotated[float, "N*m/s**2"]
    # 1 where every signal has been present for the settling time, apart from bridged gaps
    settled: Annotated[float, ""]
    present: Annotated[float, ""]  # 1 where every signal is present in this sample


@dataclass(frozen=True)
class AngleObserver:
    """Steering wheel angle: the integrated rate, corrected slowly by the measured angle, behind a play operator.

    The integral has no quantisation steps, and the measured angle has no drift.

    Args:
        correction_time: time constant of the correction by the measured angle [s]; 0.2 is a gain of 0.05 per
            sample of 10 ms. A shorter one passes the steps of a coarse angle, a longer one the noise of the rate
        half_width: half width of the play [rad]; zero, since a play of 3e-4 delays each reversal: it cost 0.1 to
            0.3 N*m of 12.5 at a Dahl angle of 3 degrees on the plant of the tuning (docs/explanation/friction.md) and
            improved nothing. A rate noisier than 0.05 rad/s may need it

    Source: docs/explanation/friction.md, the default estimator.
    """

    correction_time: Annotated[float, "s"] = 0.2
    half_width: Annotated[float, "rad"] = 0.0

    class State(NamedTuple):
        integral: Scalar
        angle: Scalar
        rate: Scalar

    def init(self) -> State:
        return self.State(0.0, 0.0, 0.0)

    def step(
        self, state: State, angle: Scalar, rate: Scalar, restart: Scalar, sample_time: Any
    ) -> tuple[State, Scalar]:
        share = share_reached(sample_time / self.correction_time)
        predicted = state.integral + 0.5 * sample_time * (rate + state.rate)
        integral = where(restart, angle, predicted + share * (angle - predicted))
        held = limit(state.angle, integral - self.half_width, integral + self.half_width)
        increment = where(restart, 0.0, held - state.angle)
        return self.State(integral, where(restart, angle, held), rate), increment


@dataclass(frozen=True)
class SteeringConditioning:
    """Hold, low-pass and differentiate all signals of a friction estimator in the same way.

    A low-pass on one signal alone would delay it against the others; equal filters preserve the torque balance.
    """

    sample_time: Annotated[float, "s"] = SAMPLE_TIME  # time between two samples [s]
    # cutoff frequency of the low-pass on every signal [Hz]. Friction is not a linear function of the angle, so what the
    # low-pass removes from the angle is lost to the friction model. On the plant of the tuning
    # (docs/explanation/friction.md) 5 Hz cost 0.3 N*m of 12.5 at a Dahl angle of 3 degrees and 12 Hz 0.1, while above
    # 15 Hz a rate noise of 0.05 rad/s cost 0.2
    cutoff: Annotated[float, "Hz"] = 12.0
    # longest gap bridged with the last value [s]; one lost message of a 20 ms bus with its jitter
    bridged_gap: Annotated[float, "s"] = 0.05
    # time after a longer gap in which the estimator is disabled [s]; ten time constants of the angle observer
    settling_time: Annotated[float, "s"] = 2.0
    angle: AngleObserver = field(default_factory=AngleObserver)  # observer of the angle
    hold: InputHold = field(init=False, repr=False)
    low_pass: Butterworth = field(init=False, repr=False)

    Sample = SteeringSample

    class State(NamedTuple):
        hold: Any
        low_pass: Any
        signals: SteeringSample
        driver_torque_rate: Scalar
        angle: AngleObserver.State
        since_gap: Scalar

    def __post_init__(self) -> None:
        object.__setattr__(self, "hold", InputHold(SteeringSample, self.sample_time, self.bridged_gap))
        object.__setattr__(self, "low_pass", Butterworth(SteeringSample, self.sample_time, 0.0, self.cutoff))

    def init(self) -> State:
        zeros = SteeringSample(*[0.0] * len(SteeringSample._fields))
        return self.State(self.hold.init(), self.low_pass.init(), zeros, 0.0, self.angle.init(), -self.sample_time)

    def step(self, state: State, sample: SteeringSample) -> tuple[State, ConditionedSteering]:
        sample = map_leaves(lambda value: where(absolute(value) < _LARGEST, value, math.inf), sample)
        now_present = all_of(*(present(value) for value in values_of(sample)))
        hold, held = self.hold.step(state.hold, sample)
        bridged = all_of(*(present(value) for value in values_of(held)))
        low_pass, filtered = self.low_pass.step(state.low_pass, held)
        pairs = zip(leaves(filtered), leaves(state.signals), strict=True)
        signals = rebuild(state.signals, [where(present(new), new, old) for (_, new), (_, old) in pairs])
        elapsed = minimum(state.since_gap + self.sample_time, 2.0 * self.settling_time + 1.0)
        since_gap = where(bridged, elapsed, -self.sample_time)
        # Also true in the first complete sample after a gap, whose differences would span the whole gap.
        restart = since_gap < 0.5 * self.sample_time
        angle, increment = self.angle.step(
            state.angle, signals.steering_wheel_angle, signals.steering_wheel_rate, restart, self.sample_time
        )

        def slope(now: Scalar, before: Scalar) -> Scalar:
            return where(restart, 0.0, now - before) / self.sample_time

        torque_rate = slope(signals.driver_torque, state.signals.driver_torque)
        return self.State(hold, low_pass, signals, torque_rate, angle, since_gap), ConditionedSteering(
            signals,
            increment,
            slope(signals.steering_wheel_rate, state.signals.steering_wheel_rate),
            slope(signals.yaw_rate, state.signals.yaw_rate),
            slope(signals.vehicle_speed, state.signals.vehicle_speed),
            torque_rate,
            slope(torque_rate, state.driver_torque_rate),
            since_gap > self.settling_time - 0.5 * self.sample_time,
            now_present,
        )
