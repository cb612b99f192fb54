"""Unscented Kalman filter for models with few states, with the sample and the estimate of `KalmanFilter`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

from tierod.core.block import Scalar, Tree, rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import sqrt
from tierod.methods.estimators.gaussian import GaussianFilter, Prediction
from tierod.methods.estimators.kernels import Correction, correct_jointly, known_variances
from tierod.methods.estimators.linear_algebra import (
    Noise,
    Vector,
    add,
    cholesky,
    diagonal,
    dot,
    from_diagonal,
    minus,
    plus,
    scaled_congruence,
    times,
    upper,
)
from tierod.methods.estimators.shapes import Belief, leaf_values

_MOST_STATES = 12


@dataclass(frozen=True)
class UnscentedFilter(GaussianFilter):
    """Scaled unscented filter: 2 n + 1 sigma points propagate mean and covariance through the model without Jacobians.

    Args:
        alpha: spread of the points: they lie alpha sqrt(n + kappa) standard deviations from the mean; small values
            sample the model locally (and lose digits to cancellation), large ones average over it
        beta: additional weight of the centre in the covariance; 2.0 is optimal for a Gaussian
        kappa: second scale; 0.0 usually, 3 - n matches fourth moments (with a negative centre weight for n > 3)
        redraw: whether new points are drawn about the prediction before the correction; True makes it equal to the
            Kalman filter for a linear model, False saves a factorisation

    The other fields, the sample and the estimate are those of `GaussianFilter`. Input noise enters by the Jacobian with
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
