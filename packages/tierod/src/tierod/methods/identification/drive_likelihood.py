"""The likelihood of an ordinary drive, from the innovations of a car's filter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, rebuild
from tierod.core.graph.maths import both, log, present, sqrt, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import correct_in_turn
from tierod.methods.estimators.linear_algebra import Vector, from_diagonal, plus, upper
from tierod.methods.estimators.shapes import Belief, leaf_values
from tierod.methods.identification.drive_model import MOVING

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
    """The terms of the likelihood of a drive.

    Args:
        filter: from `drive_filter`
        ratio: road-wheel angle over the measured angle
    """

    filter: KalmanFilter
    ratio: Annotated[float, ""]

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
