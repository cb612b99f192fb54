"""Lateral motion of a car in an ordinary drive, with sensor zeros, road bank and steering compliance as states, and the
likelihood of a drive.

Zeros of the sensors are constant states, so that every drive has its own; bank and twist of the steering are
Gauss-Markov processes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Model, Scalar, Tree, model_like, rebuild
from tierod.core.graph.maths import both, log, present, sqrt, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import correct_in_turn
from tierod.methods.estimators.linear_algebra import Vector, from_diagonal, plus, upper
from tierod.methods.estimators.shapes import Belief, leaf_values
from tierod.models.lateral_motion import lateral_motion
from tierod.models.lateral_parameters import LateralParameters, Sampled
from tierod.physics.gravity import GRAVITY
from tierod.physics.lag import gauss_markov_noise

UNKNOWNS = ("bank_angle", "lateral_acceleration_bias", "yaw_rate_bias", "road_wheel_angle_offset")
_MOTION = lateral_motion(UNKNOWNS, roll=True)
MOVING = ("lateral_speed", "yaw_rate", "front_deflection", "rear_deflection", "roll_angle", "roll_rate")

START = {
    "lateral_speed": 0.3,
    "yaw_rate": 0.1,
    "front_deflection": 0.01,
    "rear_deflection": 0.01,
    "roll_angle": 0.01,
    "roll_rate": 0.03,
}
"""Standard deviations of the motion at the start of a stretch of driving, in the units of the states."""

GATE = 16.0  # Gate of the filter: bound of a squared innovation over its variance, beyond which the noise is raised


class DriveState(NamedTuple):
    """Motion with its unknowns, and the steering angle reading straight ahead, at the road wheels."""

    motion: _MOTION.State  # type: ignore[name-defined]  # made at run time
    steering_zero: Annotated[float, "rad"]


@dataclass(frozen=True)
class DriveParameters:
    """Parameters of the model."""

    sampled: Sampled  # of the lateral motion
    # share of the lateral acceleration in a bend that the bank of the road compensates
    superelevation: Annotated[float, ""] = 0.0


def _driven(x: DriveState, u: Tree) -> Tree:
    return u._replace(road_wheel_angle=u.road_wheel_angle - x.steering_zero)


def _transition(x: DriveState, u: Tree, p: DriveParameters) -> DriveState:
    bank, pulled = x.motion.bank_angle, u.vehicle_speed * x.motion.yaw_rate
    # Roads are banked in bends: this part of the bank follows the bend, only the deviation from it is a state.
    on_road = x.motion._replace(bank_angle=bank - p.superelevation / GRAVITY * pulled)
    moved = _MOTION.transition(on_road, _driven(x, u), p.sampled)
    return DriveState(moved._replace(bank_angle=bank * p.sampled.fading[0]), x.steering_zero)


def _output(x: DriveState, u: Tree, p: DriveParameters) -> Tree:
    return _MOTION.output(x.motion, _driven(x, u), p.sampled)


DRIVE_MODEL: Model = model_like(
    _MOTION,
    "DriveModel",
    "Lateral motion with a zero of the steering angle.",
    State=DriveState,
    Parameters=DriveParameters,
    transition=_transition,
    output=_output,
)


@dataclass(frozen=True)
class DriveNoises:
    """Noises of model and sensors in an ordinary drive, named as in a vehicle file where it has them."""

    # yaw_rate_noise, lateral_acceleration_noise: standard deviation of one measurement
    yaw_rate_noise: Annotated[float, "rad/s"] = 0.004
    lateral_acceleration_noise: Annotated[float, "m/s**2"] = 0.3
    # lateral_speed_drift, yaw_rate_drift: growth of the model error per square root of time
    lateral_speed_drift: Annotated[float, "m/s**1.5"] = 0.05
    yaw_rate_drift: Annotated[float, "rad/s**1.5"] = 0.02
    roll_rate_drift: Annotated[float, "rad/s**1.5"] = 0.002  # growth of the model error per square root of time
    # bank_wander, bank_wander_time: standard deviation and correlation time of the bank beside the superelevation
    bank_wander: Annotated[float, "rad"] = 0.015
    bank_wander_time: Annotated[float, "s"] = 10.0
    # share of the lateral acceleration in a bend that the bank of the road compensates
    superelevation: Annotated[float, ""] = 0.1
    # road_wheel_angle_wander, road_wheel_angle_wander_time: standard deviation and correlation time of the error of the
    # angle, by twist and gears
    road_wheel_angle_wander: Annotated[float, "rad"] = 0.001
    road_wheel_angle_wander_time: Annotated[float, "s"] = 3.0
    # lateral_acceleration_zero, yaw_rate_zero, steering_zero: prior standard deviations of the sensor zeros
    lateral_acceleration_zero: Annotated[float, "m/s**2"] = 0.2
    yaw_rate_zero: Annotated[float, "rad/s"] = 0.01
    steering_zero: Annotated[float, "rad"] = 0.005


def drive_filter(car: LateralParameters, noises: DriveNoises, sample_time: float) -> KalmanFilter:
    """The Kalman filter of a car in a drive.

    Args:
        sample_time: sampling interval [s]
    """
    bank = noises.bank_wander, noises.bank_wander_time
    angle = noises.road_wheel_angle_wander, noises.road_wheel_angle_wander_time
    fading = (math.exp(-sample_time / bank[1]), 1.0, 1.0, math.exp(-sample_time / angle[1]))
    deviations = (
        *(START[name] for name in MOVING),
        *(noises.bank_wander, noises.lateral_acceleration_zero, noises.yaw_rate_zero),
        *(noises.road_wheel_angle_wander, noises.steering_zero),
    )
    process = (
        noises.lateral_speed_drift**2 * sample_time,
        noises.yaw_rate_drift**2 * sample_time,
        None,
        None,
        None,
        noises.roll_rate_drift**2 * sample_time,
        float(gauss_markov_noise(*bank, sample_time)),
        None,
        None,
        float(gauss_markov_noise(*angle, sample_time)),
        None,
    )
    return KalmanFilter(
        DRIVE_MODEL,
        DriveParameters(Sampled(car, sample_time, usual=(0.0,) * len(UNKNOWNS), fading=fading), noises.superelevation),
        initial_mean=(0.0,) * len(deviations),
        initial_variance=tuple(each**2 for each in deviations),
        process_noise=process,
        measurement_noise=(noises.yaw_rate_noise**2, noises.lateral_acceleration_noise**2),
        gate=GATE,
    )


SLOWEST = 2.0
"""Speed below which samples are left out [m/s]: slow tyres give little information, and the steer is large."""


class DriveSample(NamedTuple):
    """Signals of an ordinary drive; NaN where missing."""

    vehicle_speed: Annotated[Scalar, "m/s"]
    longitudinal_acceleration: Annotated[Scalar, "m/s**2"]
    steering_angle: Annotated[Scalar, "rad"]
    yaw_rate: Annotated[Scalar, "rad/s"]
    lateral_acceleration: Annotated[Scalar, "m/s**2"]


class DriveScore(NamedTuple):
    """Innovations of a sample over their standard deviations, logarithms of the latter, and estimated sensor zeros.

    The zeros, with their variances, are those of steering angle at the road wheels, yaw rate and lateral acceleration
    after the sample.
    """

    whitened_yaw_rate: Annotated[Scalar, ""]
    whitened_lateral_acceleration: Annotated[Scalar, ""]
    spread_yaw_rate: Annotated[Scalar, ""]
    spread_lateral_acceleration: Annotated[Scalar, ""]
    steering_zero: Annotated[Scalar, "rad"]
    yaw_rate_zero: Annotated[Scalar, "rad/s"]
    lateral_acceleration_zero: Annotated[Scalar, "m/s**2"]
    steering_variance: Annotated[Scalar, "rad**2"]
    yaw_rate_variance: Annotated[Scalar, "rad**2/s**2"]
    lateral_acceleration_variance: Annotated[Scalar, "m**2/s**4"]


@dataclass(frozen=True)
class DriveLikelihood:
    """The terms of the likelihood of a drive."""

    filter: KalmanFilter  # from `drive_filter`
    ratio: Annotated[float, ""]  # road-wheel angle over the measured angle

    Sample = DriveSample
    Output = DriveScore

    def init(self) -> Belief:
        return self.filter.init()

    def step(self, state: Belief, sample: DriveSample) -> tuple[Belief, DriveScore]:
        """State and score after one sample; below `SLOWEST` the motion is reset and the zeros are kept."""
        kind = self.filter.model
        angle = self.ratio * sample.steering_angle
        running = both(both(present(sample.vehicle_speed), present(angle)), sample.vehicle_speed > SLOWEST)
        inputs = kind.Input(
            where(running, sample.vehicle_speed, SLOWEST),
            where(present(sample.longitudinal_acceleration), sample.longitudinal_acceleration, 0.0),
            where(running, angle, 0.0),
        )
        given = self.filter.Sample(inputs, kind.Output(sample.yaw_rate, sample.lateral_acceleration))
        belief, whitened, spread = self._filtered(state, given)
        mean = [where(running, a, b) for a, b in zip(leaf_values(belief.mean), self._still(state), strict=True)]
        covariance = [
            where(running, a, b) for a, b in zip(belief.covariance, self._forgotten(state.covariance), strict=True)
        ]
        after = Belief(rebuild(state.mean, mean), tuple(covariance))
        size = len(mean)
        at = {pair: k for k, pair in enumerate(upper(size))}
        zeros = (size - 1, 8, 7)  # places of steering zero, yaw rate bias and lateral acceleration bias in the state
        score = DriveScore(
            *(where(running, each, 0.0) for each in (*whitened, *spread)),
            *(mean[k] for k in zeros),
            *(covariance[at[k, k]] for k in zeros),
        )
        return after, score

    def _filtered(self, state: Belief, sample: Tree) -> tuple[Belief, list[Scalar], list[Scalar]]:
        predicted = self.filter._predict(state, sample.input, leaf_values(self.filter.process_noise), ())
        rows, residuals, known = self.filter.innovations(predicted, sample)
        noise = self.filter.bounded_noise(leaf_values(self.filter.measurement_noise), known, residuals)
        done = correct_in_turn(predicted.covariance, rows, residuals, noise)
        mean = [plus(a, b) for a, b in zip(predicted.mean, done.correction.shift, strict=True)]
        whitened, spread = [], []
        for residual, variance in zip(done.residuals, done.spreads, strict=True):
            there = present(residual)
            whitened.append(where(there, residual, 0.0) / sqrt(variance))
            spread.append(where(there, 0.5 * log(variance), 0.0))
        return Belief(rebuild(state.mean, mean), done.correction.covariance), whitened, spread

    def _still(self, state: Belief) -> Vector:
        """Mean at standstill: zero motion, other states unchanged."""
        values = leaf_values(state.mean)
        return tuple(0.0 if k < len(MOVING) else value for k, value in enumerate(values))

    def _forgotten(self, covariance: Vector) -> Vector:
        """Covariance at standstill: the initial one for the motion, without correlation with the other states."""
        first = from_diagonal(leaf_values(self.filter.initial_variance))
        moving = len(MOVING)
        pairs = upper(len(leaf_values(self.filter.initial_variance)))
        return tuple(a if i < moving else b for (i, _), a, b in zip(pairs, first, covariance, strict=True))
