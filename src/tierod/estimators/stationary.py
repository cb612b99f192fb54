"""Stationary Kalman gain from the Riccati equation, and the filter that uses it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.block import Tree, rebuild, skeleton
from tierod.errors import ParameterError
from tierod.estimators.kernels import correct_jointly
from tierod.estimators.linear_algebra import diagonal, order, upper
from tierod.estimators.luenberger import check_gain, observe
from tierod.estimators.pole_placement import Gain
from tierod.estimators.shapes import (
    check_model,
    check_variances,
    class_of_innovation_variance,
    class_of_variance,
    estimate_class,
    leaf_names,
    leaf_values,
    sample_class,
)
from tierod.graph.maths import where
from tierod.models.linear import LinearSystem, linearise
from tierod.models.modes import TOLERANCE, describe, modes


@dataclass(frozen=True, eq=False)
class StationaryGain:
    """Limit of a Kalman filter for a constant system.

    Args:
        filter: gain K of x = x- + K (y - C x-), (n, outputs): what every estimator of tierod takes
        predictor: gain A K of x-(k+1) = A x-(k) + B u + A K (y - C x-), (n, outputs): what dlqe of python-control
            returns
        predicted_covariance: of x-, before the measurement, (n, n)
        covariance: of x, after it, (n, n)
        innovation_covariance: C P- C' + R, (outputs, outputs)
    """

    filter: np.ndarray
    predictor: np.ndarray
    predicted_covariance: np.ndarray
    covariance: np.ndarray
    innovation_covariance: np.ndarray


def stationary_gain(
    system: LinearSystem, process_noise: Any, measurement_noise: Any, input_noise: Any = None
) -> StationaryGain:
    """The stationary Kalman gain of a discrete system, by SciPy's Riccati solver.

    Args:
        system: discrete
        process_noise: variance of each state per sample, (n,), None for none; or the whole Q, (n, n)
        measurement_noise: variance of each output, (outputs,); or the whole R
        input_noise: variance of each input, (inputs,), None for none; adds B diag(w) B'

    Raises:
        ParameterError: there is no stationary gain: a direction that does not decay is not shown by the outputs (it is
            named), or has no noise
    """
    from scipy.linalg import solve_discrete_are

    A, C = system.A, system.C
    Q, R = _matrix(process_noise, len(A), "process_noise"), _matrix(measurement_noise, len(C), "measurement_noise")
    if input_noise is not None:
        Q = Q + system.B @ _matrix(input_noise, system.B.shape[1], "input_noise") @ system.B.T
    _require_detectable(system)
    try:
        predicted = solve_discrete_are(A.T, C.T, Q, R)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise _no_limit(system, str(error)) from None
    spread = C @ predicted @ C.T + R
    gain = np.linalg.solve(spread, C @ predicted).T
    left = np.eye(len(A)) - gain @ C
    if np.abs(np.linalg.eigvals(left @ A)).max() >= 1.0 - 1e-12:
        raise _no_limit(system, "the error of the filter does not decay")
    after = left @ predicted @ left.T + gain @ R @ gain.T
    return StationaryGain(gain, A @ gain, predicted, 0.5 * (after + after.T), 0.5 * (spread + spread.T))


def _matrix(noise: Any, n: int, what: str) -> np.ndarray:
    values = [0.0 if entry is None else entry for entry in noise]
    matrix = np.asarray(values, float)
    matrix = np.diag(matrix) if matrix.ndim == 1 else matrix
    if matrix.shape != (n, n) or not np.isfinite(matrix).all() or np.linalg.eigvalsh(matrix).min() < -1e-12:
        raise ParameterError(
            f"{what} gives a matrix of shape {matrix.shape}; expected {n} variances, or a ({n}, {n}) covariance"
        )
    return matrix


def _require_detectable(system: LinearSystem) -> None:
    for mode in modes(system):
        if mode.margin < TOLERANCE and abs(mode.eigenvalue) >= 1.0 - 1e-9:
            raise ParameterError(
                f"there is no stationary gain: the outputs {', '.join(system.outputs)} do not show the direction "
                f"{describe(mode.direction, system.states)} (eigenvalue {mode.number}), which does not decay; "
                "measure it, or take it out of the state"
            )


def _no_limit(system: LinearSystem, reason: str) -> ParameterError:
    lasting = [name for name, row in zip(system.states, system.A, strict=True) if np.abs(row).sum() >= 1.0]
    return ParameterError(
        f"there is no stationary gain ({reason}); give every state that does not decay by itself "
        f"(among {', '.join(lasting) or ', '.join(system.states)}) process noise greater than zero"
    )


@dataclass(frozen=True)
class StationaryFilter:
    """Kalman filter with its stationary gain: a few multiplications per sample, with the estimate of `KalmanFilter`.

    Args:
        model: discrete model
        parameters: of the model; its floats are tuning
        initial_mean: state before the first sample, one float per state
        gain: `StationaryGain.filter`, rows by state, columns by output
        covariance: packed stationary covariance, for the variances reported
        innovation_covariance: packed, for NIS

    `design` fills in the last three. The gain is that of complete samples: a missing output (NaN) corrects nothing and
    leaves the rest of the gain and the reported variance as they are; a missing input holds the state.
    """

    model: Any
    parameters: Any
    initial_mean: Tree
    gain: Gain
    covariance: tuple[float, ...]
    innovation_covariance: tuple[float, ...]

    def __post_init__(self) -> None:
        check_model(self.model)
        check_gain(self.model, self.gain, self.initial_mean)
        for what, packed, kind in (
            ("covariance", self.covariance, self.model.State),
            ("innovation_covariance", self.innovation_covariance, self.model.Output),
        ):
            n = len(leaf_names(kind))
            if len(packed) != n * (n + 1) // 2:
                raise ParameterError(f"{what} has {len(packed)} entries; expected {n * (n + 1) // 2}, packed")

    @classmethod
    def design(
        cls,
        model: Any,
        parameters: Any,
        process_noise: Tree,
        measurement_noise: Tree,
        state: Tree,
        inputs: Tree,
        input_noise: Tree = None,
    ) -> StationaryFilter:
        """The filter for a model linearised at a point.

        Args:
            model, parameters: discrete model
            process_noise, measurement_noise, input_noise: variances, as `KalmanFilter` takes them
            state, inputs: the point, where the filter starts too

        Raises:
            ParameterError: as `stationary_gain`
        """
        check_model(model)
        check_variances("process_noise", process_noise, leaf_names(model.State))
        check_variances("measurement_noise", measurement_noise, leaf_names(model.Output), positive=True)
        system = linearise(model, parameters, state, inputs)
        found = stationary_gain(system, process_noise, measurement_noise, input_noise)
        gain = tuple(tuple(map(float, row)) for row in found.filter)
        return cls(model, parameters, state, gain, _packed(found.covariance), _packed(found.innovation_covariance))

    @property
    def Sample(self) -> type:
        """NamedTuple class with `input` and `measured`."""
        return sample_class(self.model, ())

    def init(self) -> Tree:
        """The state before the first sample."""
        return rebuild(skeleton(self.model.State), leaf_values(self.initial_mean))

    def step(self, state: Tree, sample: Any) -> tuple[Tree, Any]:
        """One sample on."""
        done = observe(self.model, self.parameters, self.gain, state, sample)
        count = order(self.innovation_covariance)
        figures = correct_jointly((), [()] * count, self.innovation_covariance, done.innovation)
        nis, number = figures.nis, figures.present
        if done.whole is not True:
            nis, number = where(done.whole, nis, 0.0), where(done.whole, number, 0.0)
        mean = rebuild(state, done.mean)
        estimate = estimate_class(self.model, False)(
            mean,
            rebuild(skeleton(class_of_variance(self.model)), diagonal(self.covariance)),
            rebuild(skeleton(self.model.Output), done.innovation),
            rebuild(skeleton(class_of_innovation_variance(self.model)), diagonal(self.innovation_covariance)),
            nis,
            number,
        )
        return mean, estimate


def _packed(matrix: np.ndarray) -> tuple[float, ...]:
    return tuple(float(matrix[i, j]) for i, j in upper(len(matrix)))
