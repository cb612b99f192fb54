"""The baseline friction monitor: two estimates of the self-aligning torque and the variance of their difference."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import absolute, all_of, both, maximum, present, select, sign, where
from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.monitors.friction.signals import SteeringSample
from tierod.physics.friction import share_reached
from tierod_lab.papers.friction.joint_model import column_after, driving_torque, rate_hold


class Moments(NamedTuple):
    """Number, mean, and sum of squared deviations of a set of samples."""

    number: Scalar
    mean: Scalar
    squares: Scalar


_NONE = Moments(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RollingVariance:
    """Variance of the counted samples of the last `blocks` whole blocks.

    Moments of blocks are merged instead of running sums, so that rounding does not accumulate. The window is one of
    time: a block without counted samples still replaces the oldest.

    Source: merging after Chan, Golub, LeVeque, The American Statistician 37 (1983) 242.
    """

    block_samples: int  # samples per block, counted or not
    blocks: int  # blocks per window

    class Sample(NamedTuple):
        value: float
        counted: Annotated[float, ""]

    class State(NamedTuple):
        seen: Scalar
        present: Moments
        window: tuple[Moments, ...]
        merged: Moments

    class Spread(NamedTuple):
        """Variance over the window (0 below two samples), and number of samples behind it."""

        variance: float
        samples: Annotated[float, ""]

    def __post_init__(self) -> None:
        if self.block_samples < 1 or self.blocks < 1:
            raise ParameterError(
                f"a window of {self.blocks} blocks of {self.block_samples} samples is empty; give at least 1 of each"
            )

    def init(self) -> State:
        return self.State(0.0, _NONE, (_NONE,) * self.blocks, _NONE)

    def step(self, state: State, sample: Sample) -> tuple[State, Spread]:
        counted = both(sample.counted > 0.0, present(sample.value))
        moments = _with(state.present, where(counted, sample.value, 0.0), counted)
        seen = state.seen + 1.0
        full = seen >= float(self.block_samples)
        moved = (*state.window[1:], moments)
        window = select(full, moved, state.window)
        merged = _NONE
        for block in window:
            merged = _merge(merged, block)
        after = self.State(where(full, 0.0, seen), select(full, _NONE, moments), window, merged)
        enough = merged.number >= 2.0
        variance = merged.squares / where(enough, merged.number - 1.0, 1.0)
        return after, self.Spread(where(enough, variance, 0.0), merged.number)


def _with(moments: Moments, value: Scalar, counted: Scalar) -> Moments:
    count = moments.number + 1.0
    away = value - moments.mean
    mean = moments.mean + away / count
    added = Moments(count, mean, moments.squares + away * (value - mean))
    return select(counted, added, moments)


def _merge(a: Moments, b: Moments) -> Moments:
    count = a.number + b.number
    away, share = b.mean - a.mean, b.number / maximum(count, 1.0)
    return Moments(count, a.mean + away * share, a.squares + b.squares + away * away * a.number * share)


@dataclass(frozen=True)
class VarianceParameters:
    """Parameters of the baseline monitor, named as in a vehicle file."""

    mass: Annotated[float, "kg"]
    front_distance: Annotated[float, "m"]
    rear_distance: Annotated[float, "m"]
    front_cornering_stiffness: Annotated[float, "N/rad"]  # both tyres of an axle together
    rear_cornering_stiffness: Annotated[float, "N/rad"]
    trail: Annotated[float, "m"]  # mechanical and pneumatic trail together, l_p
    steering_ratio: Annotated[float, ""]  # road wheel angle per steering wheel angle, rho
    column_inertia: Annotated[float, "kg*m**2"]  # J_eq
    column_damping: Annotated[float, "N*m*s/rad"]  # B_eq, greater than zero
    motor_ratio: Annotated[float, ""]  # turns of the motor per turn of the wheel, n
    nominal_friction: Annotated[float, "N*m"]  # T_f of the fault-free steering, which the observer models
    sample_time: Annotated[float, "s"] = 0.01  # dt


@dataclass(frozen=True)
class VarianceGate:
    """Gate that opens where the linear single-track model is valid.

    Source: Mohtat et al., section 4.2. On simulated drives it is open 2.7 % of the time (printed: 36 %).
    """

    # steering wheel angle of 10 degrees, lateral acceleration from 0.1 to 0.5, slip of the front tyres of 5 degrees
    minimum_angle: Annotated[float, "rad"] = math.radians(10.0)
    minimum_acceleration: Annotated[float, "m/s**2"] = 0.1
    maximum_acceleration: Annotated[float, "m/s**2"] = 0.5
    maximum_slip: Annotated[float, "rad"] = math.radians(5.0)

    def opened(self, steering_wheel_angle: Scalar, lateral_acceleration: Scalar, front_slip: Scalar) -> Scalar:
        """Whether the sample counts towards the variance; a missing signal closes the gate."""
        acceleration = absolute(lateral_acceleration)
        return all_of(
            absolute(steering_wheel_angle) > self.minimum_angle,
            self.minimum_acceleration < acceleration,
            acceleration < self.maximum_acceleration,
            absolute(front_slip) < self.maximum_slip,
        )


class AligningTorqueObserver(NamedTuple):
    """State of the disturbance observer: motion of the column, and torque of the tyres on it."""

    steering_wheel_angle: Scalar
    steering_wheel_rate: Scalar
    self_aligning_torque: Scalar


class VarianceOutput(NamedTuple):
    """Output of the baseline monitor after a sample."""

    external_torque: Annotated[float, "N*m"]  # self-aligning torque from the motion of the vehicle, eq (1)
    internal_torque: Annotated[float, "N*m"]  # self-aligning torque from the column, eq (2)
    variance: Annotated[float, "N**2*m**2"]  # variance of their difference over the window
    samples: Annotated[float, ""]  # number of samples in that variance
    ready: Annotated[float, ""]  # 1 where there are enough samples
    enabled: Annotated[float, ""]  # 1 where the sample counted
    fault: Annotated[float, ""]  # 1 where the variance is above the threshold


@dataclass(frozen=True)
class VarianceFrictionMonitor:
    """Infer friction from the variance of the difference of two self-aligning torques.

    A Luenberger observer of angle, rate and self-aligning torque models the nominal friction only; friction beyond it
    appears as a self-aligning torque with the sign of the rate. The observer takes the sign from the measured rate.

    Args:
        threshold: variance above which friction is faulty [(N m)^2]; inf gives no verdict. Take a high quantile of
            healthy drives of the same car: it depends on every parameter error
        gate: the printed conditions, or None to count every sample
        literal_sign: eq (1) with the printed minus, which compares the torque with its negative; to show its effect
        pole_rate: triple pole of the observer [1/s]; 15 follows steering and still filters [assumed]
        minimum_speed: least vehicle speed [m/s]; eq (1) divides by it, and tyre scrub is not a self-aligning torque
        block_samples, blocks: the window, 15 s at 100 Hz in steps of 1 s [assumed]
        minimum_samples: least number of samples for a variance [-]; a fifth of the window

    The decision statistic is the variance over the threshold; a value above one is a fault.

    Source: Mohtat et al., eqs (1) and (2), section 4.1, after Lin and Ghoneim, 2016. In eq (1) the sign is plus and
    the last numerator C_r, see `aligning_torque_from_steer`.
    """

    parameters: VarianceParameters
    threshold: Annotated[float, "N**2*m**2"]
    gate: VarianceGate | None
    literal_sign: bool = False
    pole_rate: Annotated[float, "1/s"] = 15.0
    minimum_speed: Annotated[float, "m/s"] = 3.0
    block_samples: int = 100
    blocks: int = 15
    minimum_samples: Annotated[float, ""] = 300.0
    alarm: HeldThreshold = field(default=HeldThreshold(1.0, 1, "upper"), init=False)

    Sample = SteeringSample

    class State(NamedTuple):
        observer: AligningTorqueObserver
        driver_torque: Scalar
        motor_torque: Scalar
        rate: Scalar
        window: RollingVariance.State

    def init(self) -> State:
        window = RollingVariance(self.block_samples, self.blocks)
        return self.State(AligningTorqueObserver(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, window.init())

    def step(self, state: State, sample: SteeringSample) -> tuple[State, VarianceOutput]:
        observer = self._observe(state, sample.steering_wheel_angle)
        external = self._external_torque(sample)
        # Every signal is present, and the vehicle fast enough for eq (1).
        whole = all_of(sample.vehicle_speed > self.minimum_speed, *(present(value) for value in values_of(sample)))
        enabled = both(whole, self._gated(sample, external))
        rolling = RollingVariance(self.block_samples, self.blocks)
        counted = rolling.Sample(external - observer.self_aligning_torque, enabled)
        window, spread = rolling.step(state.window, counted)
        ready = spread.samples >= self.minimum_samples
        _, above = self.alarm.step(self.alarm.init(), spread.variance / self.threshold, ready)
        inputs = (sample.driver_torque, sample.motor_torque, sample.steering_wheel_rate)
        held = (state.driver_torque, state.motor_torque, state.rate)
        driver, motor, rate = (where(present(new), new, old) for new, old in zip(inputs, held, strict=True))
        after = self.State(observer, driver, motor, rate, window)
        return after, VarianceOutput(
            external,
            observer.self_aligning_torque,
            spread.variance,
            spread.samples,
            where(ready, 1.0, 0.0),
            enabled,
            above.alarm,
        )

    def _observe(self, state: State, angle: Scalar) -> AligningTorqueObserver:
        """Observer of eq (2) for one sample, corrected by the measured angle; a missing angle corrects nothing."""
        p, before = self.parameters, state.observer
        angle_gain, rate_gain, torque_gain = self.observer_gains()
        # The correction belongs to the sample before: the observer predicts, as the poles were placed.
        net = driving_torque(state.driver_torque, state.motor_torque, before.self_aligning_torque, p)
        net = net - p.nominal_friction * sign(state.rate)
        predicted = AligningTorqueObserver(
            *column_after(before.steering_wheel_angle, before.steering_wheel_rate, net, p),
            before.self_aligning_torque,
        )
        error = where(present(angle), angle - predicted.steering_wheel_angle, 0.0)
        return AligningTorqueObserver(
            predicted.steering_wheel_angle + angle_gain * error,
            predicted.steering_wheel_rate + rate_gain * error,
            predicted.self_aligning_torque + torque_gain * error,
        )

    def observer_gains(self) -> tuple[Scalar, Scalar, Scalar]:
        """Gains of angle [-], rate [1/s] and torque [N m/rad] on the angle error that place the triple pole."""
        p = self.parameters
        decay, gain = rate_hold(p.sample_time, p.column_damping, p.column_inertia)
        coupling = gain * p.steering_ratio
        step = share_reached(self.pole_rate * p.sample_time)
        # Predictor gains by comparing coefficients of (z - 1 + step)^3, then the gains of the corrector: A^-1 L.
        angle_gain = 3.0 * step - (1.0 - decay)
        rate_gain = (3.0 * step * step - angle_gain * (1.0 - decay)) / p.sample_time
        torque_gain = -step * step * step / (p.sample_time * coupling)
        rate_gain = (rate_gain + coupling * torque_gain) / decay
        return angle_gain - p.sample_time * rate_gain, rate_gain, torque_gain

    def _external_torque(self, sample: SteeringSample) -> Scalar:
        speed = maximum(sample.vehicle_speed, self.minimum_speed)
        motion = (sample.steering_wheel_angle, sample.lateral_acceleration, sample.yaw_rate, speed)
        torque = aligning_torque_from_steer(*motion, self.parameters)
        return -torque if self.literal_sign else torque

    def _gated(self, sample: SteeringSample, external_torque: Scalar) -> Scalar:
        if self.gate is None:
            return 1.0
        slip = external_torque / (self.parameters.trail * self.parameters.front_cornering_stiffness)
        return self.gate.opened(sample.steering_wheel_angle, sample.lateral_acceleration, slip)


def aligning_torque_from_steer(
    angle: Scalar, lateral_acceleration: Scalar, yaw_rate: Scalar, speed: Scalar, p: VarianceParameters
) -> Scalar:
    """Self-aligning torque [N*m] of the linear single track from the motion of steering wheel [rad] and vehicle.

    Source: Mohtat et al., eq (1), corrected: the last numerator is Cr (printed Cf), and the sign is plus (printed
    minus), since eqs (2) to (4) take the torque as resisting: Mz = lp Cf/(Cf+Cr) (m ay + Cr rho theta - Cr L r/v).
    """
    front, rear, wheelbase = p.front_cornering_stiffness, p.rear_cornering_stiffness, p.front_distance + p.rear_distance
    turned = rear * p.steering_ratio * angle - rear * wheelbase * yaw_rate / speed
    return p.trail * (front / (front + rear) * (p.mass * lateral_acceleration + turned))
