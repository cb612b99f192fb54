"""Kalman filter, linear time-varying and extended alike, for any discrete model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, rebuild, skeleton
from tierod.core.graph.derivatives import jacobian
from tierod.core.graph.maths import maximum, present, where
from tierod.methods.estimators.gaussian import GaussianFilter, Prediction
from tierod.methods.estimators.kernels import Correction, correct, predict_covariance
from tierod.methods.estimators.linear_algebra import Matrix, Noise, Vector, plus, quadratic
from tierod.methods.estimators.shapes import Belief, leaf_values


class Innovations(NamedTuple):
    """Innovations of measurements against a prediction.

    Args:
        rows: Jacobian of the outputs with respect to the state, m rows of n
        residuals: measured minus expected output, (m,); NaN where missing
        known: variance of each expected output, (m,)
    """

    rows: Matrix
    residuals: Vector
    known: Vector


@dataclass(frozen=True)
class KalmanFilter(GaussianFilter):
    """Extended Kalman filter with automatic Jacobians; for a linear model the Kalman filter itself.

    W = F P, P = W F' + Q + G diag(w) G', then one scalar update per output on a symmetric P, all linearised at the
    predicted mean, so that the order of the outputs does not matter. `GaussianFilter` explains the fields, the sample
    and the estimate.

    Valid while the model is nearly linear over a few standard deviations; compare with `UnscentedFilter` in doubt. The
    covariance stays positive in double precision while the initial variance of the measured quantity is below about
    1e12 times the measurement noise.

    Args:
        gate: bound of the squared innovation over its variance, a quantile of chi-square with one degree of freedom
            (10.83 for 99.9 %). For a measurement beyond, the noise is raised until it lies on the bound: the farther
            out it is, the less it moves the estimate, and the filter never rejects all. None: no gate

    Source: R. E. Kalman, 1960, doi 10.1115/1.3662552; masks after S. F. Schmidt, 1966, and Mohtat et al., Table 3;
    gate after Chang, Journal of Geodesy 88 (2014) 391, for each measurement alone.
    """

    gate: Annotated[float, ""] | None = None

    def _predict(self, state: Belief, inputs: Tree, process: Noise, entering: Noise) -> Prediction:
        def transition(mean: Tree) -> Tree:
            return self.model.transition(mean, inputs, self.parameters)

        rows = jacobian(transition, state.mean)
        gain, variances = self._noise_gain(state.mean, inputs, entering)
        covariance = predict_covariance(rows, state.covariance, process, gain, variances)
        return Prediction(leaf_values(transition(state.mean)), covariance)

    def innovations(self, predicted: Prediction, sample: Tree) -> Innovations:
        """Innovations of a sample's measurements against a prediction."""

        def output(at: Tree) -> Tree:
            return self.model.output(at, sample.input, self.parameters)

        at = rebuild(skeleton(self.model.State), predicted.mean)
        rows = jacobian(output, at)
        pairs = zip(leaf_values(sample.measured), leaf_values(output(at)), strict=True)
        known = [quadratic(row, predicted.covariance) for row in rows]
        return Innovations(rows, tuple(measured - expected for measured, expected in pairs), known)

    def bounded_noise(self, noise: Vector, known: Vector, innovation: Vector) -> Vector:
        """Noise variance of every measurement, raised where its innovation lies beyond the gate."""
        if self.gate is None:
            return noise
        return tuple(_widened(self.gate, *each) for each in zip(noise, known, innovation, strict=True))

    def _correct(
        self, predicted: Prediction, sample: Tree, noise: Vector, start: Vector
    ) -> tuple[Correction, Vector, Vector]:
        rows, innovation, known = self.innovations(predicted, sample)
        noise = self.bounded_noise(noise, known, innovation)
        spread = tuple(plus(each, value) for each, value in zip(known, noise, strict=True))
        return correct(predicted.covariance, rows, innovation, noise, start), innovation, spread


def _widened(gate: Scalar, noise: Scalar, known: Scalar, innovation: Scalar) -> Scalar:
    """Noise variance of a measurement, raised where its innovation lies beyond the gate; unchanged where missing."""
    return maximum(noise, where(present(innovation), innovation * innovation, 0.0) / gate - known)
