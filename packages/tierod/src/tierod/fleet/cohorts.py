"""Cohorts of a fleet that differ, and the level expected of a new car of a cohort, as a prior for its vehicle file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.fleet.learning import Learnt
from tierod.fleet.series import Series
from tierod.methods.trends.cohort_effects import LEAST, Cohort, Cohorts, cohorts

NOMINAL = {"friction torque at the steering wheel axis": "nominal_friction"}
"""Quantity of a finding, and the parameter of a vehicle file that holds its fault-free value."""


@dataclass(frozen=True, eq=False)
class Cohorted:
    """Cohort effects of one quantity.

    Args:
        cohorts: every cohort with its odds, and the spread from car to car; None if the fleet has too few cars
        remark: why there are none
    """

    cohorts: Cohorts | None
    remark: str = ""

    @property
    def differing(self) -> tuple[Cohort, ...]:
        """Cohorts whose odds of differing from the fleet exceed one."""
        return () if self.cohorts is None else tuple(each for each in self.cohorts.all if each.log_odds > 0.0)


def cohorted(series: Series, level: np.ndarray, deviation: np.ndarray, known: Learnt) -> Cohorted:
    """Cohort effects of a quantity from the levels of all cars."""
    if len(level) < LEAST:
        return Cohorted(None, f"{len(level)} cars are too few to compare cohorts; {LEAST} are the least")
    return Cohorted(cohorts(level, deviation, series.labels, 0.5 * known.changes.step))


@dataclass(frozen=True)
class Expected:
    """Level expected of a new car.

    Args:
        value, standard_deviation: its fault-free level and standard deviation [unit]
        source: origin of the value in words, for a vehicle file
    """

    value: float
    standard_deviation: float
    source: str


def expected_of(found: Cohorts, series: Series, labels: dict[str, str]) -> Expected:
    """Level expected of a new car, from the fleet mean and the effects of its cohorts."""
    for kind, name in labels.items():
        known = sorted({each for each in series.labels.get(kind, ()) if each})
        if name not in known:
            raise ParameterError(
                f"no car of the fleet has {kind} '{name}'; known are {', '.join(known[:10]) or 'none of that kind'}"
            )
    mine = [each for each in found.all if labels.get(each.kind) == each.name and each.log_odds > 0.0]
    value = found.mean + sum(each.effect for each in mine)
    variance = found.between**2 + found.deviation**2 + sum(each.deviation**2 for each in mine)
    cohort = ", ".join(f"{each.kind} {each.name} ({each.effect:+.3g})" for each in mine)
    source = (
        f"fleet of {len(series.vehicles)} cars: mean {found.mean:.4g} with {found.between:.3g} from car to car"
        + (f"; {cohort}" if cohort else "")
        + f", {series.watched.unit}"
    )
    return Expected(float(value), math.sqrt(variance), source)


def write_prior(path: str | Path, series: Series, expected: Expected) -> Path:
    """Write the level expected of a new car into a vehicle file, as value, standard deviation and source."""
    from tierod.core.files import write_text
    from tierod.vehicles import load
    from tierod.vehicles.writer import Change, changed

    quantity = series.watched.quantity
    if quantity not in NOMINAL:
        raise ParameterError(
            f"no parameter of a vehicle file holds the fault-free value of '{quantity}'; known are {', '.join(NOMINAL)}"
        )
    target = Path(path)
    load(target)  # an error in the file is reported with its line before anything is written
    try:
        text = target.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{target} cannot be read: {error.strerror}; check its path and permissions") from None
    change = Change(expected.value, expected.standard_deviation, expected.source)
    return write_text(target, changed(text, {NOMINAL[quantity]: change}))
