"""Observers with a fixed gain, their gain from the Riccati equation, and fixed-lag smoothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple, TypeAlias, get_type_hints

import numpy as np

from tierod.core.block import Model, Scalar, Tree, Truth, named_tuple, rebuild, require_discrete, skeleton
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.maths import present, where
from tierod.methods.estimators.kernels import Vector, add, dot, plus, product, usable
from tierod.methods.estimators.shapes import check_mean, filled, leaf_names, leaf_values, sample_class
from tierod.models.linear import TOLERANCE, LinearSystem, describe, modes

# Variances (None for no noise), or a full covariance matrix
Noises: TypeAlias = Sequence[float | None] | Sequence[Sequence[float]] | np.ndarray


@dataclass(frozen=True, eq=False)
class StationaryGain:
    """Steady state of a Kalman filter for a time-invariant system."""

    filter: np.ndarray  # gain K of x = x- + K (y - C x-), (n, outputs), as used by the estimators of tierod
    # gain A K of x-(k+1) = A x-(k) + B u + A K (y - C x-), (n, outputs), as returned by dlqe of python-control
    predictor: np.ndarray
    predicted_covariance: np.ndarray  # of x-, before the measurement, (n, n)
    covariance: np.ndarray  # of x, after the measurement, (n, n)
    innovation_covariance: np.ndarray  # C P- C' + R, (outputs, outputs)


def stationary_gain(
    system: LinearSystem, process_noise: Noises, measurement_noise: Noises, input_noise: Noises | None = None
) -> StationaryGain:
    """The stationary Kalman gain of a discrete system, by SciPy's Riccati solver.

    Args: process_noise: variance of each state per sample, (n,), None for none; or the full Q, (n, n);
    measurement_noise: variance of each output, (outputs,); or the full R; input_noise: variance of each input,
    (inputs,), None for none; adds B diag(w) B'.
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
    # Joseph's form keeps the covariance positive in spite of rounding.
    after = left @ predicted @ left.T + gain @ R @ gain.T
    return StationaryGain(gain, A @ gain, predicted, 0.5 * (after + after.T), 0.5 * (spread + spread.T))


def _matrix(noise: Noises, n: int, what: str) -> np.ndarray:
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
                f"there is no stationary gain: through {', '.join(system.outputs)} the direction "
                f"{describe(mode.direction, system.states)} (eigenvalue {mode.number}) is not observable and does not "
                "decay; "
                "measure it, or take it out of the state"
            )


def _no_limit(system: LinearSystem, reason: str) -> ParameterError:
    lasting = [name for name, row in zip(system.states, system.A, strict=True) if np.abs(row).sum() >= 1.0]
    return ParameterError(
        f"there is no stationary gain ({reason}); give every state that does not decay by itself "
        f"(among {', '.join(lasting) or ', '.join(system.states)}) process noise greater than zero"
    )


Gain = tuple[tuple[float, ...], ...]  # Rows by state, columns by output


class Step(NamedTuple):
    """One step of an observer, flat: corrected mean, innovations, and whether all inputs are present (True if none)."""

    mean: Vector
    innovation: Vector
    whole: Truth


def observe(model: Model, parameters: Tree, gain: Gain, state: Tree, sample: Tree) -> Step:
    """Step x- = f(x, u), x = x- + L (y - h(x-)); missing outputs correct nothing, a missing input holds the state."""
    predicted = model.transition(state, sample.input, parameters)
    expected = leaf_values(model.output(predicted, sample.input, parameters))
    innovation = tuple(y - z for y, z in zip(leaf_values(sample.measured), expected, strict=True))
    used = [where(present(value), value, 0.0) for value in innovation]
    mean: Vector = add(leaf_values(predicted), product(gain, used))
    whole = usable(leaf_values(sample.input))
    if whole is not True:
        mean = tuple(where(whole, new, old) for new, old in zip(mean, leaf_values(state), strict=True))
    return Step(mean, innovation, whole)


def check_gain(model: Model, gain: Gain, initial_mean: Tree) -> None:
    states, outputs = leaf_names(model.State), leaf_names(model.Output)
    if len(gain) != len(states) or any(len(row) != len(outputs) for row in gain):
        raise ParameterError(
            f"the gain has {len(gain)} rows of {sorted({len(row) for row in gain})} entries; expected {len(states)} "
            f"({', '.join(states)}) of {len(outputs)} ({', '.join(outputs)})"
        )
    check_mean(initial_mean, states)


@dataclass(frozen=True)
class Luenberger:
    """Observer x- = f(x, u), x = x- + L (y - h(x-)) with a fixed gain, for any discrete model.

    A sample is `input` and `measured`; a missing output (NaN) corrects nothing, a missing input holds the state. The
    output is `mean` and `innovation` (measured minus expected; NaN where missing).

    Source: D. G. Luenberger, 1971, doi 10.1109/TAC.1971.1099826.
    """

    model: Model
    parameters: Tree  # of the model; its floats are tuning
    initial_mean: Tree  # state before the first sample, one float per state
    gain: Gain  # L, rows by state, columns by output; faster poles follow changes sooner and pass more noise

    def __post_init__(self) -> None:
        require_discrete(self.model)
        check_gain(self.model, self.gain, self.initial_mean)

    @property
    def Sample(self) -> type:
        return sample_class(self.model, ())

    def init(self) -> Tree:
        return rebuild(skeleton(self.model.State), leaf_values(self.initial_mean))

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Tree]:
        done = observe(self.model, self.parameters, self.gain, state, sample)
        return rebuild(state, done.mean), filled(_estimate_class(self.model), done.mean, done.innovation)


@lru_cache(maxsize=256)
def _estimate_class(model: Model) -> type:
    return named_tuple("Estimate", [("mean", model.State), ("innovation", model.Output)])


class LagState(NamedTuple):
    """Mean of the filter, and for each smoothed state the estimates of the last samples, the newest first."""

    mean: Tree
    recent: tuple[tuple[Scalar, ...], ...]


@dataclass(frozen=True)
class FixedLag(Luenberger):
    """Stationary Kalman filter with some of its states smoothed over a fixed lag.

    x(k-N | k) = x(k-N | k-N) + sum over j = 1 .. N of W_j e(k-N+j), where e is the innovation and
    W_j = P A' [(I - K C)' A']^(j-1) C' S^-1. Each new innovation corrects the N stored estimates, so that a step costs
    N multiplications per output and smoothed state.

    `design` computes gain, weights and variances. A sample is `input` and `measured`; a missing output corrects
    nothing, a missing input holds the state. The output is `mean` (now), `innovation` and `smoothed` (N samples ago).

    Source: B. D. O. Anderson and J. B. Moore, Optimal Filtering, 1979, section 7.3.
    """

    states: tuple[str, ...]
    weights: tuple[tuple[tuple[float, ...], ...], ...]  # W_j of each smoothed state, by lag, then by output
    variances: tuple[float, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.weights) != len(self.states) or len({len(each) for each in self.weights}) != 1:
            raise ParameterError(
                f"weights are those of {len(self.weights)} states; expected {len(self.states)} "
                f"({', '.join(self.states)}), all over the same lag"
            )

    @classmethod
    def design(
        cls,
        system: LinearSystem,
        model: Model,
        parameters: Tree,
        process_noise: Noises,
        measurement_noise: Noises,
        states: tuple[str, ...],
        lag: int,
    ) -> FixedLag:
        """The smoother of a discrete linear system and its model."""
        if lag < 1:
            raise ParameterError(f"lag is {lag}; expected at least 1 sample, or a filter without lag")
        for name in states:
            if name not in system.states:
                raise ParameterError(f"the system has no state '{name}'{nearest(name, system.states)}")
        found = stationary_gain(system, process_noise, measurement_noise)
        chosen = [system.states.index(name) for name in states]
        left = (np.eye(len(system.A)) - found.filter @ system.C).T @ system.A.T
        information = np.linalg.inv(found.innovation_covariance)
        carried = found.covariance[chosen] @ system.A.T
        weights, variances = [], np.diag(found.covariance)[chosen].copy()
        for _ in range(lag):
            weight = carried @ system.C.T @ information
            variances -= np.einsum("ij,jk,ik->i", weight, found.innovation_covariance, weight)
            weights.append(weight)
            carried = carried @ left
        by_state = tuple(tuple(tuple(map(float, w[k])) for w in weights) for k in range(len(states)))
        gain = tuple(tuple(map(float, row)) for row in found.filter)
        start = (0.0,) * len(system.A)
        return cls(model, parameters, start, gain, tuple(states), by_state, tuple(map(float, variances)))

    @property
    def lag(self) -> int:
        """Lag of the smoothed estimate behind the newest measurement [samples]."""
        return len(self.weights[0])

    @property
    def Estimate(self) -> type:
        return _lag_estimate_class(self.model, self.states)

    def at(self, mean: Tree) -> LagState:
        """The state of a smoother that starts at a mean, with the same value at all past samples."""
        values = dict(zip(leaf_names(self.model.State), leaf_values(mean), strict=True))
        return LagState(mean, tuple((values[name],) * self.lag for name in self.states))

    def init(self) -> LagState:
        return self.at(super().init())

    def step(self, state: LagState, sample: Tree) -> tuple[LagState, Tree]:
        done = observe(self.model, self.parameters, self.gain, state.mean, sample)
        used = [where(present(value), value, 0.0) for value in done.innovation]
        if done.whole is not True:
            used = [where(done.whole, value, 0.0) for value in used]
        mean = rebuild(state.mean, done.mean)
        now = dict(zip(leaf_names(self.model.State), done.mean, strict=True))
        recent, smoothed = [], []
        for name, waiting, weights in zip(self.states, state.recent, self.weights, strict=True):
            moved = [plus(value, dot(weight, used)) for value, weight in zip(waiting, weights, strict=True)]
            smoothed.append(moved[-1])
            recent.append((now[name], *moved[:-1]))
        return LagState(mean, tuple(recent)), filled(self.Estimate, done.mean, done.innovation, smoothed)


@lru_cache(maxsize=64)
def _smoothed_class(model: Model, states: tuple[str, ...]) -> type:
    hints = get_type_hints(model.State, include_extras=True)
    return named_tuple("Smoothed", [(name, hints.get(name, Annotated[float, ""])) for name in states])


@lru_cache(maxsize=64)
def _lag_estimate_class(model: Model, states: tuple[str, ...]) -> type:
    parts = [("mean", model.State), ("innovation", model.Output), ("smoothed", _smoothed_class(model, states))]
    return named_tuple("LagEstimate", parts)
