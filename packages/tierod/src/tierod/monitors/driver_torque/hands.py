"""The two hypotheses about a steering wheel, hands off and hands on, each as a Kalman filter."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.graph.maths import absolute, both, either, limit, log, negated, present, select, sqrt, where
from tierod.methods.detectors import Cusum
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import unpack, upper
from tierod.methods.estimators.shapes import Belief, augment
from tierod.methods.filters import Differentiator, FirstOrderLowPass
from tierod.models.linear import discretise
from tierod.models.steering_column import SteeringWheel, SteeringWheelParameters
from tierod.monitors.driver_torque.design import FINE, SensorNoise
from tierod.physics.friction import gauss_markov_noise
from tierod.vehicles import Vehicle

# Parameters that the filter of a wheel without hands learns.
LEARNT = ("inertia_error", "steering_wheel_damping", "torque_offset")


@dataclass(frozen=True)
class Hands:
    """Model of hands on a steering wheel, and of the wheel without them."""

    # Standard deviation of the torque of holding hands; light hands on a straight road.
    torque: Annotated[float, "N*m"] = 0.15
    # Correlation time of that torque. A longer one delays the detection of hands off; a shorter one mistakes hands that
    # hold still for a moment for hands off.
    correlation_time: Annotated[float, "s"] = 0.1
    inertia: Annotated[float, "kg*m**2"] = 0.007  # inertia that the arms add to the wheel
    damping: Annotated[float, "N*m*s/rad"] = 0.08  # damping that the arms add to the wheel
    # Standard deviation of the torque without hands, which the model lacks.
    rest_torque: Annotated[float, "N*m"] = 0.005
    rest_time: Annotated[float, "s"] = 0.02  # correlation time of that torque


@dataclass(frozen=True)
class Tolerance:
    """Uncertainty of the wheel before anything is learnt, one standard deviation."""

    # Relative, of inertia and damping; a smaller one gains almost nothing, as both are learnt within seconds.
    share: Annotated[float, ""] = 0.1
    offset: Annotated[float, "N*m"] = 0.05  # offset of the measured torque; usual for production sensors
    # Time in which parameters change by about the same amount again, 10 h.
    wandering_time: Annotated[float, "s"] = 36000.0


HANDS, TOLERANCE = Hands(), Tolerance()  # light hands, and a column that is roughly known
# Smoothing time constant of the acceleration, whose noise would otherwise imitate motion [s]; at least two samples.
SMOOTHING = 0.005


class WheelRate(NamedTuple):
    """Rate of the steering wheel."""

    steering_wheel_rate: Annotated[Scalar, "rad/s"]


@dataclass(frozen=True)
class WheelAcceleration:
    """Acceleration of the steering wheel in the middle of the next sample, from its past rate.

    The lag of the smoothing is compensated to first order; uncompensated, an error of 20 % of the inertia would leave a
    tenth of its torque at 3 Hz.
    """

    slope: Differentiator  # derivative of the rate
    slow: FirstOrderLowPass  # low-passed derivative, for the compensation

    Sample = WheelRate

    class Output(NamedTuple):
        steering_wheel_acceleration: Annotated[Scalar, "rad/s**2"]

    @classmethod
    def at(cls, sample_time: float) -> WheelAcceleration:
        """The filters for a sampling interval [s]."""
        smoothing = max(SMOOTHING, 2.0 * sample_time)
        return cls(
            Differentiator(WheelRate, sample_time, 0.0, smoothing),
            FirstOrderLowPass(cls.Output, sample_time, 0.0, smoothing),
        )

    def init(self) -> Tree:
        return self.slope.init(), self.slow.init()

    def step(self, state: Tree, sample: WheelRate) -> tuple[Tree, Output]:
        quick, slopes = self.slope.step(state[0], sample)
        now = self.Output(slopes.steering_wheel_rate)
        late, before = self.slow.step(state[1], now)
        lag = (self.slope.time_constant + 0.5 * self.slope.sample_time) / self.slow.time_constant
        change = now.steering_wheel_acceleration - before.steering_wheel_acceleration
        return (quick, late), self.Output(now.steering_wheel_acceleration + lag * change)


def hands_off_filter(
    wheel: SteeringWheelParameters, sample_time: float, hands: Hands, tolerance: Tolerance, noise: SensorNoise
) -> KalmanFilter:
    """The filter that assumes almost no torque, and learns the uncertain parameters of the wheel."""
    model = discretise(augment(SteeringWheel, *LEARNT), "midpoint")
    known = (
        (tolerance.share * wheel.steering_wheel_inertia) ** 2,
        (tolerance.share * wheel.steering_wheel_damping) ** 2,
        tolerance.offset**2,
    )
    wandering = 2.0 * sample_time / tolerance.wandering_time
    entering = gauss_markov_noise(hands.rest_torque, hands.rest_time, sample_time)
    return KalmanFilter(
        model,
        model.Parameters(replace(wheel, correlation_time=hands.rest_time), sample_time),
        (0.0, 0.0, 0.0, wheel.inertia_error, wheel.steering_wheel_damping, wheel.torque_offset),
        (_ANYWHERE, _ANY_RATE, hands.rest_torque**2, *known),
        (None, None, entering, *(wandering * each for each in known)),
        (noise.angle**2,),
        (noise.torque**2, None),
        LEARNT,
        hold_missing_input=False,
    )


def hands_on_filter(
    wheel: SteeringWheelParameters, sample_time: float, hands: Hands, noise: SensorNoise
) -> KalmanFilter:
    """The filter that assumes hands with their torque, inertia and damping; arguments as in `hands_off_filter`."""
    model = discretise(SteeringWheel, "midpoint")
    held = replace(
        wheel,
        steering_wheel_inertia=wheel.steering_wheel_inertia + hands.inertia,
        steering_wheel_damping=wheel.steering_wheel_damping + hands.damping,
        correlation_time=hands.correlation_time,
    )
    return KalmanFilter(
        model,
        model.Parameters(held, sample_time),
        (0.0, 0.0, 0.0),
        (_ANYWHERE, _ANY_RATE, hands.torque**2),
        (None, None, gauss_markov_noise(hands.torque, hands.correlation_time, sample_time)),
        (noise.angle**2,),
        (noise.torque**2, None),
        hold_missing_input=False,
    )


_ANYWHERE = 100.0  # initial variance of the wheel's angle, without information [rad^2]
_ANY_RATE = 25.0  # initial variance of the wheel's rate [rad^2/s^2]


def log_likelihood(estimate: Tree) -> Scalar:
    """Log-likelihood of the angle of one sample, less a constant; 0 where it is missing."""
    there = estimate.present > 0.5
    spread = where(there, estimate.innovation_variance.steering_wheel_angle, 1.0)
    nats: Scalar = where(there, -0.5 * (estimate.nis + log(spread)), 0.0)
    return nats


def begun(start: Belief, motion: Belief, learnt: Belief, begins: Scalar, otherwise: Belief) -> Belief:
    """A hypothesis that is restarted in this sample, or continued."""
    count = len(start.mean)
    mean = [*motion.mean[:2], start.mean[2], *learnt.mean[3:count]]
    moving, expected, known = unpack(motion.covariance), unpack(start.covariance), unpack(learnt.covariance)
    # Blocks of motion, torque and parameters are taken from three beliefs, hence without cross-covariances.
    covariance = [
        moving[i][j] if j < 2 else expected[i][j] if i == j == 2 else known[i][j] if i > 2 else 0.0
        for i, j in upper(count)
    ]
    return Belief(
        select(begins, type(start.mean)(*mean), otherwise.mean), select(begins, tuple(covariance), otherwise.covariance)
    )


def relearning(belief: Belief, learnt: Belief, anew: Scalar) -> Belief:
    """The belief with its parameters reset to the learnt ones, where learning restarts."""
    return begun(belief, belief, learnt, anew, belief)


OFF, UNCERTAIN, ON = 0.0, 0.5, 1.0  # codes of the state of the hands
# Thresholds of the log-likelihood ratio for "on" and for "off" [nat]; see `OFF_DESIGN` of the decisions.
THRESHOLDS = (30.0, 33.0)
BEYOND = 4.0  # standard deviations of the tolerance beyond which learnt values are rejected


class HandsSample(NamedTuple):
    """Input of the monitor of the hands."""

    steering_wheel_angle: Annotated[Scalar, "rad"]
    driver_torque: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class HandsMonitor:
    """Hands on, hands off or uncertain: two hypotheses about the torque on the wheel, tested sequentially.

    Two Kalman filters follow the wheel. One assumes almost no external torque and the wheel of the vehicle file, within
    a tolerance that it narrows by learning inertia, damping and offset while no hands are on the wheel; the other
    assumes a torque that wanders, and the additional inertia and damping of the arms. Their log-likelihood ratio is
    accumulated in two CUSUMs, one for each change of the state.
    """

    off: KalmanFilter  # off, on: filters of both hypotheses
    on: KalmanFilter
    to_on: Cusum  # to_on, to_off: CUSUMs of the log-likelihood ratio, each with its threshold
    to_off: Cusum
    motion: WheelAcceleration  # acceleration of the wheel, from the rate of the accepted hypothesis
    sample_time: Annotated[float, "s"]  # sampling interval
    # greatest_offset, greatest_inertia_error: bounds beyond which learnt values are discarded and the state of the
    # hands is unknown
    greatest_offset: Annotated[float, "N*m"]
    greatest_inertia_error: Annotated[float, "kg*m**2"]
    most: Annotated[float, ""] = 5.0  # bound of the evidence of a single sample, so that an outlier decides nothing
    # share of a threshold from which contrary evidence makes the present state uncertain
    doubt: Annotated[float, ""] = 0.5
    calm: Annotated[float, ""] = 0.2  # share of the threshold above which evidence for hands stops all learning
    # least_rate, least_acceleration: bounds below which damping and inertia are not learnt, since they would fit noise
    least_rate: Annotated[float, "rad/s"] = 0.2
    least_acceleration: Annotated[float, "rad/s**2"] = 5.0
    longest_gap: Annotated[float, "s"] = 0.1  # time of missing samples after which the state of the hands is unknown
    # standard deviation of the torque's change over a single missing sample; after more of them the motion of the wheel
    # is reinitialised
    unseen_torque: Annotated[float, "N*m"] = 0.2
    # greatest_acceleration, greatest_torque_rate: bounds beyond which a sample is rejected as an outlier
    greatest_acceleration: Annotated[float, "rad/s**2"] = 3000.0
    greatest_torque_rate: Annotated[float, "N*m/s"] = 3000.0

    Sample = HandsSample

    class State(NamedTuple):
        off: Belief  # off, on: beliefs of both hypotheses
        on: Belief
        learnt: Belief  # last belief of the wheel without hands that was beyond doubt
        to_on: Cusum.State  # to_on, to_off: states of the CUSUMs
        to_off: Cusum.State
        hands: Annotated[Scalar, ""]  # the decision
        last: HandsSample  # last accepted sample
        smooth: Tree  # smooth, rate, acceleration: motion of the wheel
        rate: Annotated[Scalar, "rad/s"]
        acceleration: Annotated[Scalar, "rad/s**2"]
        gap: Annotated[Scalar, "s"]  # time since the last accepted sample [s]

    class Output(NamedTuple):
        hands: Annotated[Scalar, ""]  # 1 on, 0 off, 0.5 uncertain
        evidence_on: Annotated[Scalar, ""]  # evidence_on, evidence_off: CUSUMs over their thresholds
        evidence_off: Annotated[Scalar, ""]
        log_likelihood_ratio: Annotated[Scalar, ""]  # log-likelihood ratio of this sample, on against off
        inertia_error: Annotated[Scalar, "kg*m**2"]  # inertia_error, torque_offset: values learnt without hands
        torque_offset: Annotated[Scalar, "N*m"]
        nis_off: Annotated[Scalar, ""]  # nis_off, nis_on: NIS of both filters
        nis_on: Annotated[Scalar, ""]

    @classmethod
    def of_vehicle(
        cls,
        vehicle: Vehicle,
        sample_time: float,
        hands: Hands = HANDS,
        tolerance: Tolerance = TOLERANCE,
        noise: SensorNoise = FINE,
        thresholds: tuple[float, float] = THRESHOLDS,
    ) -> HandsMonitor:
        """The monitor for a vehicle."""
        wheel = vehicle.parameters_for(SteeringWheelParameters)
        to_on, to_off = thresholds
        return cls(
            hands_off_filter(wheel, sample_time, hands, tolerance, noise),
            hands_on_filter(wheel, sample_time, hands, noise),
            Cusum(0.0, to_on, to_on, "upper"),
            Cusum(0.0, to_off, to_off, "lower"),
            WheelAcceleration.at(sample_time),
            sample_time,
            BEYOND * tolerance.offset,
            BEYOND * tolerance.share * wheel.steering_wheel_inertia,
        )

    def init(self) -> State:
        off, nothing = self.off.init(), self.Sample(0.0, 0.0)
        sums = self.to_on.init(), self.to_off.init()
        return self.State(
            off, self.on.init(), off, *sums, UNCERTAIN, nothing, self.motion.init(), 0.0, 0.0, self.longest_gap
        )

    def step(self, state: State, sample: HandsSample) -> tuple[State, Output]:
        accepted = self._accepted(state, sample)
        state = self._begun(state, accepted, sample)
        # The mean over the sample: the torque at its beginning, held, would lag by half a sample.
        torque = where(accepted, 0.5 * (state.last.driver_torque + sample.driver_torque), state.last.driver_torque)
        inputs = SteeringWheel.Input(torque, state.acceleration)
        measured = SteeringWheel.Output(where(accepted, sample.steering_wheel_angle, math.inf))
        noise = (self.off.input_noise[0] + where(accepted, 0.0, self.unseen_torque * self.unseen_torque), None)
        off_sample = self.off.Sample(inputs, measured, self._learning(state))
        off_belief, off = self.off.step(state.off, off_sample, input_noise=noise)
        on_belief, on = self.on.step(state.on, self.on.Sample(inputs, measured), input_noise=noise)
        ratio = limit(log_likelihood(on) - log_likelihood(off), -self.most, self.most)
        to_on, up = self.to_on.step(state.to_on, ratio)
        to_off, down = self.to_off.step(state.to_off, ratio)
        hands = where(up.alarm, ON, where(down.alarm, OFF, state.hands))
        rate = where(hands < 0.25, off.mean.steering_wheel_rate, on.mean.steering_wheel_rate)
        smooth, moved = self.motion.step(state.smooth, WheelRate(rate))
        last = select(accepted, sample, state.last)
        gap = where(accepted, 0.0, state.gap + self.sample_time)
        motion = (smooth, rate, moved.steering_wheel_acceleration)
        beliefs = (off_belief, on_belief, state.learnt)
        after = self.State(*beliefs, to_on, to_off, hands, last, *motion, gap)
        return after, self._output(hands, ratio, up.up, down.down, state.learnt.mean, off, on)

    def _accepted(self, state: State, sample: HandsSample) -> Scalar:
        elapsed = state.gap + self.sample_time
        moved = sample.steering_wheel_angle - state.last.steering_wheel_angle - state.rate * elapsed
        twisted = sample.driver_torque - state.last.driver_torque
        noise = 10.0 * sqrt(self.off.measurement_noise[0])
        possible = both(
            absolute(moved) < noise + self.greatest_acceleration * elapsed * elapsed,
            absolute(twisted) < self.greatest_torque_rate * elapsed,
        )
        there = both(present(sample.steering_wheel_angle), present(sample.driver_torque))
        return both(there, either(possible, self._lost(state)))

    def _lost(self, state: State) -> Scalar:
        return state.gap + 0.5 * self.sample_time > self.longest_gap

    def _begun(self, state: State, accepted: Scalar, sample: HandsSample) -> State:
        """The state before the update, with hypotheses restarted where evidence or gaps demand it.

        After a long gap, or with implausible learnt parameters, the state of the hands is unknown. While the evidence
        for "off" is zero, the filter without hands keeps only parameters learnt beyond doubt.
        """
        off, on, lost = self.off.init(), self.on.init(), self._lost(state)
        anew = both(accepted, state.gap > 1.5 * self.sample_time)
        sure = both(state.hands < 0.25, state.to_on.up < self.calm * self.to_on.threshold)
        absurd = self._absurd(state.off.mean)
        forgotten = either(lost, absurd)
        learnt = select(both(sure, negated(forgotten)), state.off, state.learnt)
        here = off._replace(mean=off.mean._replace(steering_wheel_angle=sample.steering_wheel_angle))
        unknown = begun(off, here, learnt, anew, state.off)
        held = begun(on, here, on, anew, state.on)
        never_off = either(absurd, both(state.hands > 0.25, state.to_off.down <= 0.0))
        return state._replace(
            off=relearning(unknown, learnt, never_off),
            on=held,
            learnt=learnt,
            to_on=self.to_on.State(*(where(forgotten, 0.0, each) for each in state.to_on)),
            to_off=self.to_off.State(*(where(forgotten, 0.0, each) for each in state.to_off)),
            hands=where(forgotten, UNCERTAIN, state.hands),
            last=select(anew, sample, state.last),
            acceleration=where(anew, 0.0, state.acceleration),
        )

    def _absurd(self, wheel: Tree) -> Scalar:
        return either(
            absolute(wheel.torque_offset) > self.greatest_offset,
            absolute(wheel.inertia_error) > self.greatest_inertia_error,
        )

    def _learning(self, state: State) -> tuple[Scalar, ...]:
        alone = either(state.hands > 0.25, state.to_on.up < self.calm * self.to_on.threshold)
        shaken = both(alone, absolute(state.acceleration) > self.least_acceleration)
        turning = both(alone, absolute(state.rate) > self.least_rate)
        return tuple(where(each, 1.0, 0.0) for each in (shaken, turning, alone))

    def _output(
        self, hands: Scalar, ratio: Scalar, up: Scalar, down: Scalar, learnt: Tree, off: Tree, on: Tree
    ) -> Output:
        evidence_on, evidence_off = up / self.to_on.threshold, down / self.to_off.threshold
        against = where(hands > 0.75, evidence_off, where(hands < 0.25, evidence_on, 0.0))
        shown = where(against > self.doubt, UNCERTAIN, hands)
        errors = learnt.inertia_error, learnt.torque_offset
        return self.Output(shown, evidence_on, evidence_off, ratio, *errors, off.nis, on.nis)
