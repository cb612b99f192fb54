"""Cramer-Rao bound: the smallest standard deviation of any unbiased estimate of a state from noisy samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem, sampled

_ROUNDING = 1e-12
_TAKES_PART = 1e-6


@dataclass(frozen=True, eq=False)
class Bound:
    """Cramer-Rao bounds as standard deviations.

    Args:
        names: of the states
        start: of the state at the first sample, in its own units, (n,); infinite where it is not observable
        end: of the state at the last sample, (n,)
        condition: condition number of the sensitivities, with columns scaled to length 1
    """

    names: tuple[str, ...]
    start: np.ndarray
    end: np.ndarray
    condition: float

    def __getitem__(self, name: str) -> float:
        return float(self.end[self.names.index(name)])


def cramer_rao(
    system: LinearSystem, noise: Mapping[str, float], duration: float, sample_time: float, *, discrete: bool = False
) -> Bound:
    """The bound for an exact model without process noise and an unknown initial state.

    Disturbances, offsets and parameters are included if they are states (`extended`, or a model made by `augment` and
    linearised).

    Args:
        system: continuous, or discrete with `discrete`
        noise: standard deviation of the white noise of every output, by name
        duration: time over which samples are taken [s]
        sample_time: sampling interval [s]
        discrete: whether the system is a sampled one

    Raises:
        ParameterError: an output without a noise above zero, or less than one sample
    """
    if not 0.0 < sample_time <= duration < float("inf"):
        raise ParameterError(f"{duration} s hold no sample of {sample_time} s; expected 0 < sample_time <= duration")
    lacking = [name for name in system.outputs if not noise.get(name, 0.0) > 0.0]
    if lacking:
        raise ParameterError(f"no noise above zero is given for {', '.join(lacking)}; give its standard deviation")
    steps = system if discrete else sampled(system, sample_time)
    weights = np.array([noise[name] for name in system.outputs])
    rows, onwards = _sensitivities(steps.A, steps.C / weights[:, None], int(duration / sample_time + 1e-9))
    return _bound(rows, system.states, onwards)


def _bound(sensitivities: np.ndarray, names: tuple[str, ...], onwards: np.ndarray) -> Bound:
    """The bound from the sensitivities of all samples to the state at the start.

    Args:
        sensitivities: derivative of every sample, over its standard deviation, by every state, (samples, states)
        names: of the states
        onwards: derivative of the final state by the initial one, (states, states)
    """
    n = len(names)
    sizes = np.linalg.norm(sensitivities, axis=0)
    scale = np.where(sizes > 0.0, 1.0 / np.where(sizes > 0.0, sizes, 1.0), 1.0)
    # The rows of zeros keep the triangle square where there are fewer samples than states.
    triangle = np.linalg.qr(np.vstack([sensitivities * scale, np.zeros((n, n))]), mode="r")
    _, values, rows = np.linalg.svd(triangle)
    shown = values > _ROUNDING * values[0] if n else values > 0.0
    condition = float(values[0] / values[-1]) if n and shown.all() else float("inf")
    directions = scale[:, None] * rows.T
    return Bound(
        names,
        _spread(directions, values, shown),
        _spread(onwards @ directions, values, shown),
        condition,
    )


def _spread(directions: np.ndarray, values: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """Standard deviation of each state; infinite where an unobservable direction contributes to it."""
    sizes = np.linalg.norm(directions, axis=1)
    parts = np.abs(directions[:, ~shown]) > _TAKES_PART * np.where(sizes > 0.0, sizes, 1.0)[:, None]
    finite = np.sqrt(((directions[:, shown] / values[shown]) ** 2).sum(axis=1))
    return np.where(parts.any(axis=1), np.inf, finite)


def _sensitivities(A: np.ndarray, C: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """C A^k of all samples, stacked, and A^(samples - 1); the number of samples is doubled with every product."""
    rows, power, count = C, A, 1
    while count < samples:
        more = min(count, samples - count)
        rows = np.vstack([rows, rows[: more * len(C)] @ power])
        power, count = power @ power, count + more
    return rows, np.linalg.matrix_power(A, max(samples - 1, 0))
