"""Gains of an observer over the speed, and the error of an observer with a fixed gain."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, Self

import numpy as np

from tierod.core.block import Scalar, Tree, rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import limit, maximum, present, where
from tierod.methods.estimators.observers import observe
from tierod.methods.estimators.shapes import leaf_names
from tierod.models.linear import LinearSystem, sampled
from tierod_lab.methods.pole_placement import discrete_poles


class Spread(NamedTuple):
    """Steady-state covariance of the corrected estimate, and of the innovation."""

    corrected: np.ndarray
    innovation: np.ndarray


def stationary_covariance(
    system: LinearSystem, gain: np.ndarray, process: Sequence[float], reading: Sequence[float]
) -> Spread:
    """Steady-state covariances of an observer with a fixed gain under process and measurement noise.

    Source: P = (I - K C)(A P A' + Q)(I - K C)' + K R K' (Joseph), solved for P.
    """
    from scipy.linalg import solve_discrete_lyapunov

    A, C, Q, R = system.A, system.C, np.diag(process), np.diag(reading)
    left = np.eye(len(A)) - gain @ C
    corrected = solve_discrete_lyapunov(left @ A, left @ Q @ left.T + gain @ R @ gain.T)
    return Spread(corrected, C @ (A @ corrected @ A.T + Q) @ C.T + R)


def error_radius(system: LinearSystem, gain: np.ndarray) -> float:
    """Spectral radius of the error dynamics (I - K C) A; below one the error decays."""
    return float(np.abs(np.linalg.eigvals((np.eye(len(system.A)) - gain @ system.C) @ system.A)).max())


LOWEST, HIGHEST, COUNT = 0.5, 70.0, 16  # Range of the speeds [m/s] for which gains are designed, and their number

HALF = 2.0
"""Speed [m/s] in the middle of the table's scale; gains go with 1/V, and over V / (V + HALF) they are nearly linear."""


HELD = (0.02**2, 20.0**2)
"""Growth per second of the variances of sideslip angle [rad2] and aligning torque [N2 m2] while they are held."""

FADING_TIME = 0.5
"""Time constant with which that growth decays once the observer runs again [s]; that of its slowest pole."""

SLOWEST = 2.0
"""Floor of the eigenvalue magnitudes [1/s], for slow ones of the steering near standstill and of the vehicle at high
speed."""


def _place(speed: Scalar) -> Scalar:
    """Row index of a speed [m/s] in the table; the rows are evenly spaced over V / (V + HALF)."""
    low, high = LOWEST / (LOWEST + HALF), HIGHEST / (HIGHEST + HALF)
    return (speed / (speed + HALF) - low) * ((COUNT - 1) / (high - low))


def _speed(share: float) -> float:
    """Speed [m/s] at a share of the table, the inverse of `_place`."""
    low, high = LOWEST / (LOWEST + HALF), HIGHEST / (HIGHEST + HALF)
    at = low + share * (high - low)
    return HALF * at / (1.0 - at)


SPEEDS = tuple(_speed(row / (COUNT - 1)) for row in range(COUNT))  # Speeds of the rows [m/s]


@dataclass(frozen=True)
class Schedule:
    """Numbers interpolated over the speed between the rows of a table; constant before the first and after the last."""

    first: tuple[float, ...]  # values at the first of `SPEEDS`
    rises: tuple[tuple[float, ...], ...]  # differences of the values from each row to the next

    @classmethod
    def through(cls, rows: Sequence[Sequence[float]]) -> Self:
        """The schedule through rows of values, one for each of `SPEEDS`."""
        values = np.asarray(rows, float)
        rises = tuple(tuple(float(v) for v in row) for row in np.diff(values, axis=0))
        return cls(tuple(float(v) for v in values[0]), rises)

    def at(self, speed: Scalar) -> tuple[Scalar, ...]:
        """The values at a speed [m/s]."""
        place = _place(maximum(speed, 0.0))
        # A sum of ramps: a value of a graph cannot index a table.
        shares = [limit(place - float(row), 0.0, 1.0) for row in range(len(self.rises))]
        return tuple(
            _sum([value, *(share * rises[k] for share, rises in zip(shares, self.rises, strict=True))])
            for k, value in enumerate(self.first)
        )


def _sum(terms: list[Scalar]) -> Scalar:
    if len(terms) == 1:
        return terms[0]
    middle = len(terms) // 2
    return _sum(terms[:middle]) + _sum(terms[middle:])


class ScheduledState(NamedTuple):
    """Mean of the observer, and growth of the variances while it was held."""

    mean: Tree
    growth: tuple[Scalar, ...]


class Scheduled(NamedTuple):
    """Output of a scheduled observer: mean, variances of the requested quantities, and the innovations."""

    mean: Tree
    variances: tuple[Scalar, ...]
    nis: Annotated[Scalar, ""]
    readings: Annotated[Scalar, ""]


@dataclass(frozen=True)
class ScheduledObserver:
    """Observer of two outputs with gains scheduled by speed; variances and innovation weights are in the same table."""

    model: Any  # discrete model, linear in its state apart from friction
    parameters: Any  # parameters of the model
    schedule: Schedule  # gain row by row, variances, and the inverse of the innovations' covariance (packed), by speed
    asked: int  # number of requested variances
    growth: tuple[float, ...]  # growth of each variance per sample while the observer is held
    fading: Annotated[float, ""]  # decay factor of that growth per sample while the observer runs

    @classmethod
    def of(cls, model: Any, parameters: Any, schedule: Schedule) -> Self:
        """The observer of sideslip angle and aligning torque, with growth and fading of their held variances."""
        step = parameters.sample_time
        return cls(model, parameters, schedule, 2, tuple(rate * step for rate in HELD), math.exp(-step / FADING_TIME))

    def start(self) -> ScheduledState:
        return ScheduledState(skeleton(self.model.State), (0.0,) * self.asked)

    def observe(
        self, state: ScheduledState, inputs: Tree, measured: Tree, speed: Scalar, running: Scalar
    ) -> tuple[ScheduledState, Scheduled]:
        """Process one sample; the state is held where the observer does not run.

        Args:
            inputs, measured: inputs and outputs of the model; a measurement may be missing, an input may not
            speed: speed at which the gain is taken [m/s]
        """
        values = self.schedule.at(speed)
        n, m = len(leaf_names(self.model.State)), len(leaf_names(self.model.Output))
        gain = [values[row * m : (row + 1) * m] for row in range(n)]
        variances, weight = values[n * m : n * m + self.asked], values[n * m + self.asked :]
        sample = _Sample(inputs, measured)
        done = observe(self.model, self.parameters, gain, state.mean, sample)  # type: ignore[arg-type]
        mean = tuple(where(running, new, old) for new, old in zip(done.mean, state.mean, strict=True))
        growth = tuple(
            where(running, self.fading * old, old + more) for old, more in zip(state.growth, self.growth, strict=True)
        )
        there = [present(value) for value in done.innovation]
        first, second = (where(flag, value, 0.0) for flag, value in zip(there, done.innovation, strict=True))
        nis = weight[0] * first * first + 2.0 * weight[1] * first * second + weight[2] * second * second
        readings = where(there[0], 1.0, 0.0) + where(there[1], 1.0, 0.0)
        after = ScheduledState(rebuild(state.mean, mean), growth)
        total = tuple(at + more for at, more in zip(variances, growth, strict=True))
        return after, Scheduled(after.mean, total, nis, readings)


class _Sample(NamedTuple):
    input: Tree
    measured: Tree


class Design(NamedTuple):
    """Model for the design of the gain at one speed."""

    system: LinearSystem  # discrete model at that speed, without friction
    continuous: LinearSystem  # continuous model, for its eigenvalues


def faster_poles(design: Design, factor: float, sample_time: float) -> np.ndarray:
    """Real discrete poles, from a factor times the magnitudes of the system's eigenvalues."""
    size = np.maximum(np.sort(np.abs(np.linalg.eigvals(design.continuous.A))), SLOWEST)
    return np.real(discrete_poles(-factor * size, sample_time))


Gain = Callable[[Design], np.ndarray]  # Design of the full-order observer's gain, (n, 2), at one speed
Functionals = Callable[[float], np.ndarray]
"""Function from speed [m/s] to rows over the state whose variances are requested."""


@dataclass(frozen=True)
class Scheduling:
    """A model at any constant speed, discretised exactly."""

    model: Any  # continuous model, linear in its state without friction
    parameters: Any  # parameters of the model, without friction
    inputs: Callable[[float], tuple[float, ...]]  # inputs of the model at a speed, zero except for the speed
    sample_time: Annotated[float, "s"]  # sampling interval [s]

    def at(self, speed: float) -> Design:
        """The model at a speed [m/s]."""
        model, p = self.model, self.parameters
        inputs = model.Input(*self.inputs(speed))
        # The model is linear and homogeneous at this speed, so unit states give the columns of A and C.
        units = [model.State(*row) for row in np.eye(len(model.State._fields)).tolist()]
        continuous = LinearSystem.of(
            np.array([model.derivative(unit, inputs, p) for unit in units]).T,
            np.array([model.output(unit, inputs, p) for unit in units]).T,
            states=model.State._fields,
        )
        return Design(sampled(continuous, self.sample_time), continuous)


def scheduled(
    model: Scheduling, gain: Gain, functionals: Functionals, process: Sequence[float], reading: Sequence[float]
) -> Schedule:
    """Schedule of gains, variances and innovation weights over all speeds."""
    rows, gains = [], []
    for speed in SPEEDS:
        design = model.at(speed)
        chosen = np.asarray(gain(design), float)
        spread = stationary_covariance(design.system, chosen, process, reading)
        asked = functionals(speed)
        weight = np.linalg.inv(spread.innovation)
        spreads = np.einsum("ij,jk,ik->i", asked, spread.corrected, asked)
        gains.append(chosen)
        rows.append([*chosen.ravel(), *spreads, weight[0, 0], weight[0, 1], weight[1, 1]])
    _require_stable_between(model, gains)
    return Schedule.through(rows)


def _require_stable_between(model: Scheduling, gains: Sequence[np.ndarray]) -> None:
    for row in range(COUNT - 1):
        for share in (0.25, 0.5, 0.75):
            speed = _speed((row + share) / (COUNT - 1))
            between = (1.0 - share) * gains[row] + share * gains[row + 1]
            worst = error_radius(model.at(speed).system, between)
            if worst >= 1.0:
                raise ParameterError(
                    f"at {speed:.3g} m/s, between two speeds for which the observer was designed, its error grows by a "
                    f"factor of {worst:.6g} per sample; choose slower poles"
                )
