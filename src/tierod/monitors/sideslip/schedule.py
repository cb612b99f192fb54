"""An observer whose gain follows the speed: gains by design at some speeds, straight lines between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, Self

import numpy as np

from tierod.core.block import Scalar, Tree, rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import limit, maximum, present, where
from tierod.methods.estimators.fixed_gain import error_radius, stationary_covariance
from tierod.methods.estimators.luenberger import observe
from tierod.methods.estimators.pole_placement import discrete_poles
from tierod.methods.estimators.shapes import leaf_names
from tierod.models.linear import LinearSystem, sampled

LOWEST, HIGHEST, COUNT = 0.5, 70.0, 16
"""Speeds [m/s] between which gains are designed, and at how many."""

HALF = 2.0
"""Speed [m/s] at which half of the table is over: gains go with 1/V, and over V / (V + HALF) they are nearly lines."""


HELD = (0.02**2, 20.0**2)
"""Growth in a second of the variances of sideslip angle [rad2] and aligning torque [N2 m2] while they are held."""

FADING_TIME = 0.5
"""In which that growth fades once the observer runs again [s]: the time of its slowest pole."""

SLOWEST = 2.0
"""Eigenvalue [1/s] taken for slower ones: of the steering near standstill, and of the vehicle at the highest speeds."""


def _place(speed: Scalar) -> Scalar:
    """Place of a speed [m/s] in the table, in rows; the rows are evenly spaced over V / (V + HALF)."""
    low, high = LOWEST / (LOWEST + HALF), HIGHEST / (HIGHEST + HALF)
    return (speed / (speed + HALF) - low) * ((COUNT - 1) / (high - low))


def _speed(share: float) -> float:
    """The speed [m/s] at a share of the table, the inverse of `_place`."""
    low, high = LOWEST / (LOWEST + HALF), HIGHEST / (HIGHEST + HALF)
    at = low + share * (high - low)
    return HALF * at / (1.0 - at)


SPEEDS = tuple(_speed(row / (COUNT - 1)) for row in range(COUNT))
"""Speeds of the rows [m/s]."""


@dataclass(frozen=True)
class Schedule:
    """Numbers that follow the speed from row to row of a table; constant before the first and after the last.

    Args:
        first: values at the first of `SPEEDS`
        rises: of the values from each row to the next
    """

    first: tuple[float, ...]
    rises: tuple[tuple[float, ...], ...]

    @classmethod
    def through(cls, rows: Sequence[Sequence[float]]) -> Self:
        """The schedule through rows of values, one for each of `SPEEDS`."""
        values = np.asarray(rows, float)
        rises = tuple(tuple(float(v) for v in row) for row in np.diff(values, axis=0))
        return cls(tuple(float(v) for v in values[0]), rises)

    def at(self, speed: Scalar) -> tuple[Scalar, ...]:
        """The values at a speed [m/s]."""
        place = _place(maximum(speed, 0.0))
        shares = [limit(place - float(row), 0.0, 1.0) for row in range(len(self.rises))]
        return tuple(
            _sum([value, *(share * rises[k] for share, rises in zip(shares, self.rises, strict=True))])
            for k, value in enumerate(self.first)
        )


def _sum(terms: list[Scalar]) -> Scalar:
    """Sum by halves, so that no long chain of additions delays the step."""
    if len(terms) == 1:
        return terms[0]
    middle = len(terms) // 2
    return _sum(terms[:middle]) + _sum(terms[middle:])


class ScheduledState(NamedTuple):
    """Mean of the observer, and by how much the variances have grown while it was held."""

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
    """An observer of two outputs with gains by speed; variances and innovations come from the same table.

    Args:
        model: discrete, linear in its state apart from friction
        parameters: of the model
        schedule: gain row by row, variances, and the inverse of the innovations' covariance (packed), by speed
        asked: number of requested variances
        growth: of each variance per sample, while the observer is held
        fading: share of that growth which is left after a sample of observing
    """

    model: Any
    parameters: Any
    schedule: Schedule
    asked: int
    growth: tuple[float, ...]
    fading: Annotated[float, ""]

    @classmethod
    def of(cls, model: Any, parameters: Any, schedule: Schedule) -> Self:
        """The observer of sideslip angle and aligning torque, with the growth and fading of its held variance.

        Args:
            model: discrete
            parameters: of the model
            schedule: for both variances
        """
        step = parameters.sample_time
        return cls(model, parameters, schedule, 2, tuple(rate * step for rate in HELD), math.exp(-step / FADING_TIME))

    def start(self) -> ScheduledState:
        """At rest, straight ahead."""
        return ScheduledState(skeleton(self.model.State), (0.0,) * self.asked)

    def observe(
        self, state: ScheduledState, inputs: Tree, measured: Tree, speed: Scalar, running: Scalar
    ) -> tuple[ScheduledState, Scheduled]:
        """One sample on; the state is held where the observer does not run.

        Args:
            state: after the sample before
            inputs, measured: of the model; a measurement may be missing, an input may not
            speed: for which the gain is taken [m/s]
            running: whether the observer runs
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
    """Model that the gain of one speed is designed for.

    Args:
        system: the sampled model at that speed, without friction
        continuous: the same before sampling, for its eigenvalues
    """

    system: LinearSystem
    continuous: LinearSystem


def faster_poles(design: Design, factor: float, sample_time: float) -> np.ndarray:
    """Real poles in the plane of samples, some factor times the sizes of the system's eigenvalues."""
    size = np.maximum(np.sort(np.abs(np.linalg.eigvals(design.continuous.A))), SLOWEST)
    return np.real(discrete_poles(-factor * size, sample_time))


Gain = Callable[[Design], np.ndarray]
"""Gain of the full-order observer, (n, 2), for one speed."""
Functionals = Callable[[float], np.ndarray]
"""Rows over the state whose variances are wanted, at a speed [m/s]."""


@dataclass(frozen=True)
class Scheduling:
    """A model whose speed is held, at any speed; sampled exactly.

    Args:
        model: continuous, linear in its state once it is without friction
        parameters: of the model, without friction
        inputs: of the model at a speed, zero but for it
        sample_time: [s]
    """

    model: Any
    parameters: Any
    inputs: Callable[[float], tuple[float, ...]]
    sample_time: Annotated[float, "s"]

    def at(self, speed: float) -> Design:
        """The model at a speed [m/s]."""
        model, p = self.model, self.parameters
        inputs = model.Input(*self.inputs(speed))
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
    """Gains, variances and weights at all speeds.

    Args:
        model: at any speed
        gain: design of a gain
        functionals: quantities with requested variances
        process: variance that each state gains per sample
        reading: variance of each measurement

    Raises:
        ParameterError: at a speed between two of the table the observer is not stable
    """
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
                    f"at {speed:.3g} m/s, between two speeds for which the observer was designed, its error grows by "
                    f"{worst:.6g} a sample; take slower poles"
                )
