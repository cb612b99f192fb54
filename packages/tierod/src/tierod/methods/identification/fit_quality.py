"""Quality of a model's fit, and parameters that recordings do not identify."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tierod.methods.identification.experiment import INTERVAL, Estimate
from tierod.models.modes import describe

LAGS = 25
"""Number of lags of the autocorrelation of residuals."""


class Whiteness(NamedTuple):
    """Autocorrelation of residuals.

    Args:
        largest: in magnitude, of lags 1 to 25, with its sign
        outside: share of these lags outside the 95 % band of white noise; 0.05 for white residuals
    """

    largest: float
    outside: float


def normalised_error(simulated: np.ndarray, measured: np.ndarray) -> float:
    """Root mean square error over the standard deviation of the measured signal [-]; NaN where that is constant."""
    known = np.isfinite(measured)
    spread = float(np.std(measured[known]))
    if not spread > 0.0:
        return float("nan")
    return float(np.sqrt(np.mean((simulated[known] - measured[known]) ** 2))) / spread


def whiteness(residuals: Sequence[np.ndarray]) -> Whiteness:
    """Whiteness of the residuals of one output in several experiments, each (n,); missing ones are left out."""
    power = sum(float(np.nansum(each**2)) for each in residuals)
    count = sum(int(np.isfinite(each).sum()) for each in residuals)
    if not power > 0.0:
        return Whiteness(0.0, 0.0)
    found = [sum(float(np.nansum(e[lag:] * e[:-lag])) for e in residuals) / power for lag in range(1, LAGS + 1)]
    bound = INTERVAL / np.sqrt(count)
    return Whiteness(float(max(found, key=abs)), float(np.mean(np.abs(found) > bound)))


UNKNOWN = 0.25
"""Relative standard deviation above which a parameter counts as unidentified [-]; with half of it the ends of the 95 %
interval differ by a factor of about two."""


class Blind(NamedTuple):
    """A direction of the free parameters that the experiments do not identify.

    Args:
        direction: as text: "0.71 motor_friction - 0.7 motor_damping"
    """

    deviation: float
    direction: str
    names: tuple[str, ...]


def profiled(information: np.ndarray, count: int) -> np.ndarray:
    """Information on the first coordinates with all others unknown (Schur complement)."""
    own, cross, rest = information[:count, :count], information[:count, count:], information[count:, count:]
    return own - cross @ np.linalg.pinv(rest, hermitian=True) @ cross.T if len(rest) else own


def blind_directions(estimate: Estimate, names: Sequence[str], unknown: float = UNKNOWN) -> list[Blind]:
    """Unidentified directions of the parameters, the worst first.

    All named parameters have to be positive, so that the coordinates of the search are logarithms and standard
    deviations are relative.

    Args:
        names: of the parameters of interest; all others are treated as unknown
        unknown: relative standard deviation above which a direction counts as unidentified
    """
    order = [estimate.index(name) for name in names]
    rest = [k for k in range(len(estimate.information)) if k not in order]
    whole = [*order, *rest]
    values, directions = np.linalg.eigh(profiled(estimate.information[np.ix_(whole, whole)], len(order)))
    found = []
    for value, direction in zip(values, directions.T, strict=True):
        deviation = 1.0 / np.sqrt(max(value, 1e-12))
        if deviation > unknown:
            parts = [k for k in np.argsort(-np.abs(direction)) if abs(direction[k]) > 0.3]
            found.append(Blind(float(deviation), describe(direction, tuple(names)), tuple(names[k] for k in parts)))
    return found


def refusal(blind: Sequence[Blind], experiments: Sequence[str], cures: Mapping[str, str]) -> str:
    """Message on parameters that the experiments do not excite, and on what to record instead.

    Args:
        cures: test that excites each parameter, by name
    """
    worst = blind[0]
    which = "this recording does" if len(experiments) == 1 else "these recordings do"
    what = worst.names[0] if len(worst.names) == 1 else f"{', '.join(worst.names[:-1])} and {worst.names[-1]} apart"
    spread = "not at all" if worst.deviation > 10.0 else f"only within {100.0 * worst.deviation:.0f} %"
    cure = "; ".join(dict.fromkeys(cures[name] for name in worst.names if name in cures))
    return (
        f"{which} not excite {what} ({', '.join(experiments)}): the direction {worst.direction} is identified "
        f"{spread}; record {cure or 'a test that excites them'} instead, or leave it out of --free"
    )
