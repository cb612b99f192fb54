"""Candidate units of a column: the stated one, else those in which its values are plausible."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.signals import SIGNALS
from tierod.core.units import COUNT, scale

RADIUS = 0.31  # Effective radius of a passenger car's wheel [m], for recordings of wheel turns without a speed


class Unit(NamedTuple):
    """A unit that a column may have."""

    name: str  # notation in a channel map
    factor: float  # factor from the value of the column to SI
    offset: float = 0.0  # offset that is added after the factor
    turns: bool = False  # whether it counts turns of a wheel, so that the factor holds a radius
    stated: bool = False  # whether the file states it


# Candidates by SI unit; of those that the values leave open and no other signal decides, the first one is chosen
_CANDIDATES: dict[str, tuple[str, ...]] = {
    "rad": ("rad", "deg"),
    "rad/s": ("rad/s", "deg/s"),
    "m/s": ("m/s", "km/h"),
    "m/s**2": ("m/s**2", "g"),
    "Pa": ("bar", "Pa"),
    "K": ("degC", "K"),
    "N": ("N", "kN"),
    "m": ("m", "mm"),
    "": ("", "percent"),
}

_TURNS = ("rpm", "rad/s")


def candidates(name: str, stated: str, values: np.ndarray, turns: bool = False) -> tuple[Unit, ...]:
    """The units that a column may have: the stated one, else those in which its values are plausible, else raw counts.

    Args:
        stated: unit in the file; "" where it has none
        values: values of the column; NaN is missing
    """
    wanted, wheel = SIGNALS[name].unit, name.startswith("wheel_speed_")
    if stated and (found := _stated(stated, wanted, wheel)) is not None:
        return (found,)
    named = [*(_TURNS if wheel and turns else ()), *_CANDIDATES.get(wanted, (wanted,))]
    if name == "motor_speed":
        named.insert(1, "rpm")
    possible = [_unit(each, wanted, wheel) for each in named]
    if wheel and not any(_plausible(name, each, values) for each in possible):
        possible = [_unit(each, wanted, wheel) for each in _TURNS]
    fitting = tuple(each for each in possible if _plausible(name, each, values))
    return fitting or (Unit(COUNT, 1.0),)


def _stated(stated: str, wanted: str, wheel: bool) -> Unit | None:
    try:
        return _unit(stated, wanted, wheel)._replace(stated=True)
    except InputError:
        return None


def _unit(name: str, wanted: str, wheel: bool) -> Unit:
    if wheel:
        try:
            return Unit(name, scale(name, "rad/s").factor * RADIUS, turns=True)
        except InputError:
            pass  # a speed then
    found = scale(name, wanted)
    return Unit(name, found.factor, found.offset)


def _plausible(name: str, unit: Unit, values: np.ndarray) -> bool:
    finite = values[np.isfinite(values)]
    if not len(finite):
        return True
    low, high = SIGNALS[name].plausible
    # Quantiles, so that single outliers do not exclude a unit.
    least, most = np.quantile(finite, (0.002, 0.998)) * unit.factor + unit.offset
    return bool(low <= least <= most <= high) and math.isfinite(float(most))
