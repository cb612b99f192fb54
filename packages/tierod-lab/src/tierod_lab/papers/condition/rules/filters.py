"""Filters behind the residuals: adaptive speed, signals of the steering, and lost shares of torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import POSITIVE
from tierod.core.graph.maths import absolute, all_of, both, either, exp, minimum, negated, present, tan, tanh, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.shapes import Belief


class Growing:
    """Model of a value whose rate is a random walk."""

    class State(NamedTuple):
        value: Annotated[float, "unit of the signal"]
        rate: Annotated[float, "unit of the signal"]

    class Input(NamedTuple):
        """No inputs."""

    class Output(NamedTuple):
        value: Annotated[float, "unit of the signal"]

    @dataclass(frozen=True)
    class Parameters:
        sample_time: Annotated[float, "s", POSITIVE]

    @staticmethod
    def transition(x: State, u: Input, p: Parameters) -> State:
        return Growing.State(x.value + p.sample_time * x.rate, x.rate)

    @staticmethod
    def output(x: State, u: Input, p: Parameters) -> Output:
        return Growing.Output(x.value)


class CarriedSpeed:
    """Model of the forward speed as the integral of an acceleration with an unknown offset."""

    class State(NamedTuple):
        forward_speed: Annotated[float, "m/s"]
        offset: Annotated[float, "m/s**2"]

    class Input(NamedTuple):
        forward_rate: Annotated[float, "m/s**2"]

    class Output(NamedTuple):
        left: Annotated[float, "m/s"]
        right: Annotated[float, "m/s"]

    Parameters = Growing.Parameters

    @staticmethod
    def transition(x: State, u: Input, p: Growing.Parameters) -> State:
        return CarriedSpeed.State(x.forward_speed + p.sample_time * (u.forward_rate - x.offset), x.offset)

    @staticmethod
    def output(x: State, u: Input, p: Growing.Parameters) -> Output:
        return CarriedSpeed.Output(x.forward_speed, x.forward_speed)


@dataclass(frozen=True)
class AdaptiveSpeed:
    """Forward speed and acceleration from accelerometer, yaw rate and both rear wheels.

    Filter I smooths the acceleration, filter II the speed of each wheel, filter III fuses them. In filter III the
    variance of a wheel grows with the fourth power of its innovation, so that a wheel that slips or fails loses its
    weight. The speed starts at the mean of the wheels, and restarts there after a long gap or where both wheels agree
    on another speed.

    Args:
        wheel_noise: standard deviation of the speed of a fault-free wheel in filter III
        rejection: innovation at which the variance of a wheel has doubled
        patience: longest gap, or time in which both wheels contradict the speed, without a restart

    Source: Li, Frey, Gauterin, section 3.5.2 and Figure 4, which leave the filters open; `design` fills them in.
    """

    track_width: Annotated[float, "m", POSITIVE]
    sample_time: Annotated[float, "s", POSITIVE]
    acceleration: KalmanFilter
    wheel: KalmanFilter
    speed: KalmanFilter
    wheel_noise: Annotated[float, "m/s", POSITIVE] = 0.05
    rejection: Annotated[float, "m/s", POSITIVE] = 0.25
    patience: Annotated[float, "s", POSITIVE] = 1.0

    class Sample(NamedTuple):
        longitudinal_acceleration: Annotated[float, "m/s**2"]
        yaw_rate: Annotated[float, "rad/s"]
        sideslip_angle: Annotated[float, "rad"]
        wheel_speed_rear_left: Annotated[float, "m/s"]
        wheel_speed_rear_right: Annotated[float, "m/s"]

    class State(NamedTuple):
        acceleration: Belief
        left: Belief
        right: Belief
        speed: Belief
        started: Scalar
        doubt: Scalar

    class Output(NamedTuple):
        forward_speed: Annotated[float, "m/s"]
        forward_rate: Annotated[float, "m/s**2"]
        offset: Annotated[float, "m/s**2"]
        left_rate: Annotated[float, "m/s**2"]
        right_rate: Annotated[float, "m/s**2"]

    @classmethod
    def design(cls, track_width: float, sample_time: float) -> AdaptiveSpeed:
        """The filters with their noises: error 4 mm/s on fault-free drives, 10 mm/s with a wheel lost for 20 s."""
        known, walk = Growing.Parameters(sample_time), (1e-6, 0.005**2 * sample_time)
        joined = KalmanFilter(CarriedSpeed, known, (0.0, 0.0), (1.0, 0.01), walk, (0.05**2, 0.05**2))

        def growing(noise: float, rate_growth: float) -> KalmanFilter:
            growth = 1e-4 * sample_time, rate_growth * sample_time
            return KalmanFilter(Growing, known, (0.0, 0.0), (100.0, 100.0), growth, (noise * noise,))

        return cls(track_width, sample_time, growing(0.05, 4.0), growing(0.03, 20.0), joined)

    def init(self) -> State:
        return self.State(self.acceleration.init(), self.wheel.init(), self.wheel.init(), self.speed.init(), 0.0, 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        before = state.speed.mean
        # `longitudinal_acceleration` solved for the rate of the forward speed.
        turning = before.forward_speed * tan(sample.sideslip_angle) * sample.yaw_rate
        rate = sample.longitudinal_acceleration + turning
        wheels = sample.wheel_speed_rear_left, sample.wheel_speed_rear_right
        first, along = self.acceleration.step(state.acceleration, _reading(self.acceleration, rate))
        left, left_wheel = self.wheel.step(state.left, _reading(self.wheel, wheels[0]))
        right, right_wheel = self.wheel.step(state.right, _reading(self.wheel, wheels[1]))
        across = 0.5 * self.track_width * sample.yaw_rate
        # Filter II predicts over a gap, which must not count as a measurement.
        smoothed = left_wheel.mean.value + across, right_wheel.mean.value - across
        readings = tuple(where(present(raw), value, raw) for raw, value in zip(wheels, smoothed, strict=True))
        there = all_of(*(present(each) for each in readings), present(rate))
        begun = both(state.started > 0.5, state.doubt < self.patience)
        start = where(begun, before.forward_speed, where(there, 0.5 * (readings[0] + readings[1]), 0.0))
        started = where(there, 1.0, where(begun, 1.0, 0.0))
        # A restart resets the speed alone; the offset of the accelerometer is still the same.
        belief = state.speed._replace(mean=before._replace(forward_speed=start))
        ahead = start + self.sample_time * (along.mean.value - before.offset)
        joined, estimate = self.speed.step(
            belief,
            self.speed.Sample(CarriedSpeed.Input(along.mean.value), CarriedSpeed.Output(*readings)),
            measurement_noise=tuple(self._noise(each - ahead) for each in readings),
        )
        speed, offset = estimate.mean
        doubted = either(negated(there), self._apart(readings, ahead))
        doubt = where(doubted, minimum(state.doubt + self.sample_time, 2.0 * self.patience), 0.0)
        output = self.Output(speed, along.mean.value - offset, offset, left_wheel.mean.rate, right_wheel.mean.rate)
        return self.State(first, left, right, joined, started, doubt), output

    def _apart(self, readings: tuple[Scalar, ...], ahead: Scalar) -> Scalar:
        left, right = (where(present(each), each, 0.0) for each in readings)
        agree = absolute(left - right) < 4.0 * self.wheel_noise
        return both(agree, absolute(0.5 * (left + right) - ahead) > 2.0 * self.rejection)

    def _noise(self, innovation: Scalar) -> Scalar:
        """Variance of a wheel that depends on its innovation [(m/s)**2]."""
        relative = where(present(innovation), innovation, 0.0) / self.rejection
        squared = relative * relative
        return self.wheel_noise * self.wheel_noise * (1.0 + squared * squared)


def _reading(each: KalmanFilter, value: Scalar) -> Tree:
    return each.Sample(Growing.Input(), Growing.Output(value))


class Smooth(NamedTuple):
    """Output of a second-order low-pass, its derivative, and whether it follows a present signal, 1.0 or 0.0."""

    value: Scalar
    rate: Scalar
    follows: Scalar


@dataclass(frozen=True)
class SteeringSignals:
    """Regressors of the linear models of torque and tie-rod force, all through the same second-order low-pass.

    Args:
        bandwidth: bandwidth of the critically damped low-pass; low enough that the angle's quantisation of 0.1 degrees
            does not dominate its second derivative
        friction_width: column rate over which the sign of the friction is smoothed

    A missing signal is held; the low-pass restarts at the first value after the gap.
    """

    bandwidth: Annotated[float, "rad/s", POSITIVE] = 30.0
    friction_width: Annotated[float, "rad/s", POSITIVE] = 0.2
    sample_time: Annotated[float, "s", POSITIVE] = 0.01

    class Sample(NamedTuple):
        steering_wheel_angle: Annotated[float, "rad"]
        steering_shaft_torque: Annotated[float, "N*m"]
        tie_rod_force: Annotated[float, "N"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    class Output(NamedTuple):
        angle: Annotated[float, "rad"]
        rate: Annotated[float, "rad/s"]
        acceleration: Annotated[float, "rad/s**2"]
        direction: Annotated[float, ""]
        torque: Annotated[float, "N*m"]
        force: Annotated[float, "N"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    def init(self) -> tuple[Smooth, ...]:
        return (Smooth(0.0, 0.0, 0.0),) * 4

    def step(self, state: tuple[Smooth, ...], sample: Sample) -> tuple[tuple[Smooth, ...], Output]:
        after = tuple(self._follow(each, value) for each, value in zip(state, sample, strict=True))
        angle, torque, force, lateral = after
        acceleration = (angle.rate - state[0].rate) / self.sample_time
        direction = tanh(angle.rate / self.friction_width)
        values = torque.value, force.value, lateral.value
        return after, self.Output(angle.value, angle.rate, acceleration, direction, *values)

    def _follow(self, before: Smooth, value: Scalar) -> Smooth:
        """Exact solution of x'' = w^2 (u - x) - 2 w x' over a sample with constant u, from the first value present."""
        there, follows = present(value), before.follows > 0.5
        travel = self.bandwidth * self.sample_time
        away = where(both(there, follows), before.value - value, 0.0)
        faded = exp(-travel)
        rest = faded * ((1.0 + travel) * away + self.sample_time * before.rate)
        rate = faded * ((1.0 - travel) * before.rate - self.bandwidth * travel * away)
        held = where(there, value, before.value)
        return Smooth(
            where(follows, before.value - away + rest, held), where(follows, rate, 0.0), where(there, 1.0, 0.0)
        )


@dataclass(frozen=True)
class LostShares:
    """Least squares with forgetting for two lost shares: missing = first share * first + second share * second.

    Args:
        memory: time constant of forgetting; longer is less noisy and later
        doubt: magnitude of the regressors below which the regularisation draws the shares to zero, in their unit

    Regressors in a constant proportion are collinear; then the regularisation alone decides between the shares.
    """

    memory: Annotated[float, "s", POSITIVE]
    doubt: Annotated[float, "unit of the signal", POSITIVE]
    sample_time: Annotated[float, "s", POSITIVE]

    class Sample(NamedTuple):
        missing: Annotated[float, "unit of the signal"]
        first: Annotated[float, "unit of the signal"]
        second: Annotated[float, "unit of the signal"]

    class Output(NamedTuple):
        first: Annotated[float, ""]
        second: Annotated[float, ""]

    def init(self) -> tuple[Scalar, ...]:
        return (0.0,) * 5

    def step(
        self, state: tuple[Scalar, ...], sample: Sample, enabled: Scalar = True
    ) -> tuple[tuple[Scalar, ...], Output]:
        # Not finite as soon as one of the three is missing.
        use = where(present((sample.missing + sample.first + sample.second) * 0.5), enabled, 0.0)
        missing, first, second = (where(use, value, 0.0) for value in sample)
        keep = exp(-self.sample_time / self.memory)
        products = (first * first, first * second, second * second, missing * first, missing * second)
        after = tuple(
            where(use, keep * old + (1.0 - keep) * new, old) for old, new in zip(state, products, strict=True)
        )
        a, b, c = after[0] + self.doubt * self.doubt, after[1], after[2] + self.doubt * self.doubt
        # Positive by the regularisation, so it needs no guard.
        determinant = a * c - b * b
        shares = (c * after[3] - b * after[4]) / determinant, (a * after[4] - b * after[3]) / determinant
        return after, self.Output(*shares)
