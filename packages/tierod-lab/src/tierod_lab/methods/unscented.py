"""Unscented Kalman filter for models with few states, with the sample and the estimate of `KalmanFilter`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

from tierod.core.block import Scalar, Tree, rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, present, sqrt, where
from tierod.methods.estimators.kalman import KalmanFilter, Prediction
from tierod.methods.estimators.kernels import (
    Correction,
    Matrix,
    Noise,
    Vector,
    add,
    diagonal,
    dot,
    downdate,
    from_diagonal,
    known_variances,
    minus,
    plus,
    scaled_congruence,
    times,
    unpack,
    upper,
)
from tierod.methods.estimators.shapes import Belief, leaf_values

_MOST_STATES = 12


@dataclass(frozen=True)
class UnscentedFilter(KalmanFilter):
    """Scaled unscented filter: 2 n + 1 sigma points propagate mean and covariance through the model without Jacobians.

    Args:
        alpha: spread of the points: they lie alpha sqrt(n + kappa) standard deviations from the mean; small values
            sample the model locally (and lose digits to cancellation), large ones average over it
        beta: additional weight of the centre in the covariance; 2.0 is optimal for a Gaussian
        kappa: second scale; 0.0 usually, 3 - n matches fourth moments (with a negative centre weight for n > 3)
        redraw: whether new points are drawn about the prediction before the correction; True makes it equal to the
            Kalman filter for a linear model, False saves a factorisation

    The other fields, the sample and the estimate are those of `KalmanFilter`. Input noise enters by the Jacobian with
    respect to the input. The computing time grows with n cubed; at most 12 states.

    Source: S. Julier, J. Uhlmann, 2004, doi 10.1109/JPROC.2003.823141; scaled form, E. Wan, R. van der Merwe, 2000,
    doi 10.1109/ASSPCC.2000.882463.
    """

    alpha: Annotated[float, ""] = 1.0
    beta: Annotated[float, ""] = 2.0
    kappa: Annotated[float, ""] = 0.0
    redraw: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        n = len(leaf_values(self.initial_mean))
        if n > _MOST_STATES:
            raise ParameterError(
                f"the unscented filter unrolls its points and takes at most {_MOST_STATES} states, this model has {n}; "
                "use KalmanFilter"
            )
        if not (self.alpha > 0.0 and n + self.kappa > 0.0):
            raise ParameterError(
                f"alpha is {self.alpha} and kappa {self.kappa}; expected alpha > 0 and kappa > -{n} (states)"
            )

    def _predict(self, state: Belief, inputs: Tree, process: Noise, entering: Noise) -> Prediction:
        points = self._points(leaf_values(state.mean), state.covariance)
        images = self._images(points, lambda at: self.model.transition(at, inputs, self.parameters))
        mean = self._mean(images)
        away = _deviations(images, mean)
        covariance = self._packed_spread(away)
        covariance = add(covariance, from_diagonal(known_variances(process)))
        gain, variances = self._noise_gain(state.mean, inputs, entering)
        if variances:
            covariance = add(covariance, scaled_congruence(gain, variances))
        return Prediction(mean, covariance, self._points(mean, covariance) if self.redraw else images)

    def _correct(
        self, predicted: Prediction, sample: Tree, noise: Vector, start: Vector
    ) -> tuple[Correction, Vector, Vector]:
        images = self._images(predicted.points, lambda at: self.model.output(at, sample.input, self.parameters))
        expected = self._mean(images)
        innovation = tuple(y - z for y, z in zip(leaf_values(sample.measured), expected, strict=True))
        away = _deviations(images, expected)
        spread = add(self._packed_spread(away), from_diagonal(noise))
        states = _deviations(predicted.points, predicted.mean)
        cross = [[self._product(away, k, states, i) for i in range(len(predicted.mean))] for k in range(len(noise))]
        correction = correct_jointly(predicted.covariance, cross, spread, innovation, start)
        return correction, innovation, diagonal(spread)

    def _points(self, mean: Vector, covariance: Vector) -> list[Vector]:
        """Sigma points: the mean, then one point on either side of it along each column of the Cholesky factor."""
        factor = cholesky(covariance)
        scale = self.alpha * sqrt(len(mean) + self.kappa)
        steps = [[times(scale, row[j]) for row in factor] for j in range(len(mean))]
        ahead = [add(mean, step) for step in steps]
        behind = [tuple(minus(x, s) for x, s in zip(mean, step, strict=True)) for step in steps]
        return [tuple(mean), *ahead, *behind]

    def _images(self, points: Sequence[Vector], function: Callable[[Tree], Tree]) -> list[Vector]:
        shape = skeleton(self.model.State)
        return [leaf_values(function(rebuild(shape, point))) for point in points]

    def _side_weight(self) -> Scalar:
        n = len(leaf_values(self.initial_mean))
        return 0.5 / (self.alpha * self.alpha * (n + self.kappa))

    def _mean(self, images: Sequence[Vector]) -> tuple[Scalar, ...]:
        """Weighted mean, as the centre plus weighted differences to it: avoids large weights of opposite sign."""
        weight = self._side_weight()
        sides = [[minus(image[k], centre) for image in images[1:]] for k, centre in enumerate(images[0])]
        return tuple(plus(c, times(weight, _total(side))) for c, side in zip(images[0], sides, strict=True))

    def _product(self, left: Sequence[Vector], i: int, right: Sequence[Vector], j: int) -> Scalar:
        n = len(leaf_values(self.initial_mean))
        side = self._side_weight()
        centre = 1.0 - 2.0 * n * side + 1.0 - self.alpha * self.alpha + self.beta
        sides = dot([a[i] for a in left[1:]], [b[j] for b in right[1:]])
        return plus(times(side, sides), times(centre, times(left[0][i], right[0][j])))

    def _packed_spread(self, away: Sequence[Vector]) -> tuple[Scalar, ...]:
        return tuple(self._product(away, i, away, j) for i, j in upper(len(away[0])))


def _deviations(points: Sequence[Vector], mean: Vector) -> list[Vector]:
    return [tuple(minus(x, m) for x, m in zip(point, mean, strict=True)) for point in points]


def _total(values: list[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for value in values:
        total = plus(total, value)
    return total


_SEMIDEFINITE = 1e-13  # pivot over its diagonal entry, below which a direction counts as known exactly


def correct_jointly(
    covariance: Vector, cross: Matrix, spread: Vector, residuals: Vector, start: Vector | None = None
) -> Correction:
    """Correction from the joint covariance of states and outputs, as sigma points give it; otherwise like `correct`.

    Args:
        cross: covariance of each output with the states, m rows of n
        residuals: measured minus expected output, (m,); NaN where the measurement is missing
        start: that the correction is added to, (n,); zeros by default
    """
    full = unpack(covariance)
    n, m = len(full), len(residuals)
    outputs = unpack(spread)
    after = [[*row, *(line[i] for line in cross)] for i, row in enumerate(full)]
    after += [[*line, *outputs[k]] for k, line in enumerate(cross)]
    shift: list[Scalar] = [*([0.0] * n if start is None else start), *[0.0] * m]
    nis: Scalar = 0.0
    count: Scalar = 0.0
    for k in range(n, n + m):
        there = present(residuals[k - n])
        inverse = 1.0 / where(there, after[k][k], math.inf)
        innovation = where(there, minus(residuals[k - n], shift[k]), 1.0)
        weighted = innovation * inverse
        column = [row[k] for row in after]
        shift = [plus(value, times(entry, weighted)) for value, entry in zip(shift, column, strict=True)]
        downdate(after, column, inverse)
        nis = plus(nis, innovation * weighted)
        count = plus(count, where(there, 1.0, 0.0))
    return Correction(tuple(shift[:n]), tuple(after[i][j] for i, j in upper(n)), nis, count)


def cholesky(packed: Vector) -> list[list[Scalar]]:
    """Lower factor L with L L' = P, rows with zeros above the diagonal.

    A direction whose pivot is negligible against its diagonal entry (known exactly, or lost to rounding) gets a column
    of zeros, so that a semidefinite P is factored without NaN.
    """
    full = unpack(packed)
    n = len(full)
    factor: list[list[Scalar]] = [[0.0] * n for _ in range(n)]
    for j in range(n):
        pivot = minus(full[j][j], dot(factor[j][:j], factor[j][:j]))
        positive = both(pivot > full[j][j] * _SEMIDEFINITE, pivot > 0.0)
        root = sqrt(where(positive, pivot, math.inf))
        factor[j][j] = where(positive, root, 0.0)
        for i in range(j + 1, n):
            factor[i][j] = minus(full[i][j], dot(factor[i][:j], factor[j][:j])) / root
    return factor
