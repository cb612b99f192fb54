"""The two hypotheses about a steering wheel, hands off and hands on, each as a Kalman filter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.graph.maths import log, select, where
from tierod.methods.estimators import KalmanFilter
from tierod.methods.estimators.augment import augment
from tierod.methods.estimators.linear_algebra import unpack, upper
from tierod.methods.estimators.shapes import Belief
from tierod.methods.filters import Differentiator, FirstOrderLowPass
from tierod.models.discretise import discretise
from tierod.models.steering_wheel import SteeringWheel, SteeringWheelParameters
from tierod.monitors.driver_torque.tuning import SensorNoise
from tierod.physics.lag import gauss_markov_noise

LEARNT = ("inertia_error", "steering_wheel_damping", "torque_offset")
"""Parameters that the filter of a wheel without hands learns."""


@dataclass(frozen=True)
class Hands:
    """Model of hands on a steering wheel, and of the wheel without them.

    Args:
        torque: standard deviation of the torque of holding hands; light hands on a straight road
        correlation_time: correlation time of that torque. A longer one delays the detection of hands off; a shorter one
            mistakes hands that hold still for a moment for hands off
        inertia: inertia that the arms add to the wheel
        damping: damping that the arms add to the wheel
        rest_torque: standard deviation of the torque without hands, which the model lacks
        rest_time: correlation time of that torque
    """

    torque: Annotated[float, "N*m"] = 0.15
    correlation_time: Annotated[float, "s"] = 0.1
    inertia: Annotated[float, "kg*m**2"] = 0.007
    damping: Annotated[float, "N*m*s/rad"] = 0.08
    rest_torque: Annotated[float, "N*m"] = 0.005
    rest_time: Annotated[float, "s"] = 0.02


@dataclass(frozen=True)
class Tolerance:
    """Uncertainty of the wheel before anything is learnt, one standard deviation.

    Args:
        share: relative, of inertia and damping; a smaller one gains almost nothing, as both are learnt within seconds
        offset: offset of the measured torque; usual for production sensors
        wandering_time: time in which parameters change by about the same amount again, 10 h
    """

    share: Annotated[float, ""] = 0.1
    offset: Annotated[float, "N*m"] = 0.05
    wandering_time: Annotated[float, "s"] = 36000.0


HANDS, TOLERANCE = Hands(), Tolerance()
"""Light hands, and a column that is roughly known."""

SMOOTHING = 0.005
"""Smoothing time constant of the acceleration, whose noise would otherwise imitate motion [s]; at least two samples."""


class WheelRate(NamedTuple):
    """Rate of the steering wheel."""

    steering_wheel_rate: Annotated[Scalar, "rad/s"]


@dataclass(frozen=True)
class WheelAcceleration:
    """Acceleration of the steering wheel in the middle of the next sample, from its past rate.

    The lag of the smoothing is compensated to first order; uncompensated, an error of 20 % of the inertia would leave a
    tenth of its torque at 3 Hz.

    Args:
        slope: derivative of the rate
        slow: low-passed derivative, for the compensation
    """

    slope: Differentiator
    slow: FirstOrderLowPass

    Sample = WheelRate

    class Output(NamedTuple):
        """Acceleration in the middle of the next sample."""

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
        """State before the first sample."""
        return self.slope.init(), self.slow.init()

    def step(self, state: Tree, sample: WheelRate) -> tuple[Tree, Output]:
        """Process one sample."""
        quick, slopes = self.slope.step(state[0], sample)
        now = self.Output(slopes.steering_wheel_rate)
        late, before = self.slow.step(state[1], now)
        lag = (self.slope.time_constant + 0.5 * self.slope.sample_time) / self.slow.time_constant
        change = now.steering_wheel_acceleration - before.steering_wheel_acceleration
        return (quick, late), self.Output(now.steering_wheel_acceleration + lag * change)


def hands_off_filter(
    wheel: SteeringWheelParameters, sample_time: float, hands: Hands, tolerance: Tolerance, noise: SensorNoise
) -> KalmanFilter:
    """The filter that assumes almost no torque, and learns the uncertain parameters of the wheel.

    Args:
        wheel: wheel as in the vehicle file
        sample_time: sampling interval [s]
        hands: torque that remains without hands
        tolerance: uncertainty of the wheel's parameters
        noise: noise of the sensors
    """
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


_ANYWHERE = 100.0
"""Initial variance of the wheel's angle, without information [rad^2]."""
_ANY_RATE = 25.0
"""Initial variance of the wheel's rate [rad^2/s^2]."""


def log_likelihood(estimate: Tree) -> Scalar:
    """Log-likelihood of the angle of one sample, less a constant; 0 where it is missing.

    Args:
        estimate: output of one of the filters
    """
    there = estimate.present > 0.5
    spread = where(there, estimate.innovation_variance.steering_wheel_angle, 1.0)
    nats: Scalar = where(there, -0.5 * (estimate.nis + log(spread)), 0.0)
    return nats


def begun(start: Belief, motion: Belief, learnt: Belief, begins: Scalar, otherwise: Belief) -> Belief:
    """A hypothesis that is restarted in this sample, or continued.

    Args:
        start: initial belief, with the prior of the hands' torque
        motion: belief of angle and rate
        learnt: belief of the wheel's parameters
        begins: whether the hypothesis restarts
        otherwise: belief that continues where it does not
    """
    count = len(start.mean)
    mean = [*motion.mean[:2], start.mean[2], *learnt.mean[3:count]]
    moving, expected, known = unpack(motion.covariance), unpack(start.covariance), unpack(learnt.covariance)
    # Blocks of motion, torque and parameters are taken from three beliefs, hence without cross-covariances.
    covariance = [
        moving[i][j] if j < 2 else expected[i][j] if i == j == 2 else known[i][j] if i > 2 else 0.0
        for i, j in upper(count)
    ]
    return Belief(
        select(begins, type(start.mean)(*mean), otherwise.mean),
        select(begins, tuple(covariance), otherwise.covariance),
    )


def relearning(belief: Belief, learnt: Belief, anew: Scalar) -> Belief:
    """The belief with its parameters reset to the learnt ones, where learning restarts.

    Args:
        belief: belief of the wheel without hands
        learnt: belief with parameters beyond doubt
        anew: whether to reset
    """
    return begun(belief, belief, learnt, anew, belief)
