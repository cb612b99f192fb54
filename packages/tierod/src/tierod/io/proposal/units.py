"""Unit of every column: the stated one, else that in which values are plausible and redundant signals agree best."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.shown import written
from tierod.core.signals import SIGNALS
from tierod.core.units import COUNT, scale
from tierod.io.proposal.motion import RATE, SECONDS, Motion, Seen
from tierod.methods.relations import compared

RADIUS = 0.31  # Effective radius of a passenger car's wheel [m], for recordings of wheel turns without a speed


class Unit(NamedTuple):
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


# Smallest difference of the squared deviations at which a unit counts as decided: two standard deviations [-]
DECISIVE = 4.0

# Bound on the squared deviation of one relation [-], so that a signal with another fault does not decide all units
MOST = 25.0

# Cost of a unit per place in the list of candidates [-], so that the usual unit is chosen where nothing decides
WORSE = 0.3

TIGHTEST = 4.0  # Radius of the tightest turn of a car, at its rear axle [m]
OFFSET = 0.1  # Reading of a yaw rate sensor that an offset explains [rad/s]

# Signals that are related to the speed, directly or through another signal
TIED = (
    "yaw_rate", "lateral_acceleration", "steering_wheel_angle", "steering_wheel_rate", "longitudinal_acceleration",
)  # fmt: skip


class Chosen(NamedTuple):
    """A unit with its reason; `decided` where the recording or the file decides it, else it is only assumed."""

    unit: Unit
    reason: str
    decided: bool


def chosen_units(motion: Motion, possible: Mapping[str, tuple[Unit, ...]]) -> dict[str, Chosen]:
    basis = motion.basis
    possible = {**possible, **_turning(motion, possible)}
    names = [name for name in (basis, *TIED) if name is not None and name in possible]
    # All combinations are compared: every relation depends on the units of several signals.
    ranked = sorted(
        ((_cost(motion, basis, dict(zip(names, units, strict=True)), possible), units)
         for units in itertools.product(*(possible[name] for name in names))),
        key=lambda pair: pair[0],
    )  # fmt: skip
    best = dict(zip(names, ranked[0][1], strict=True))
    found = {}
    for place, name in enumerate(names):
        other = next(((cost, units) for cost, units in ranked if units[place] != best[name]), None)
        found[name] = _explained(motion, basis, name, best, other and (other[0] - ranked[0][0], other[1][place]))
    for name, units in possible.items():
        if name not in found:
            found[name] = _beside(motion, name, units, found.get(basis) if basis else None)
    return found


def _turning(motion: Motion, possible: Mapping[str, tuple[Unit, ...]]) -> dict[str, tuple[Unit, ...]]:
    """The units in which a car could turn as its yaw rate says, at its speed: one that stands does not."""
    units, speed = possible.get("yaw_rate", ()), motion.speed()
    if len(units) < 2 or speed is None or motion.basis is None or len(possible[motion.basis]) > 1:
        return {}
    fastest = np.abs(speed) * possible[motion.basis][0].factor / TIGHTEST + OFFSET
    excess = [float(np.nanmedian(np.abs(motion.columns["yaw_rate"]) * each.factor - fastest)) for each in units]
    fitting = tuple(each for each, beyond in zip(units, excess, strict=True) if beyond < 0.0)
    return {"yaw_rate": fitting} if fitting else {}


def _cost(
    motion: Motion, basis: str | None, units: Mapping[str, Unit], possible: Mapping[str, tuple[Unit, ...]]
) -> float:
    total = WORSE * sum(possible[name].index(unit) for name, unit in units.items())
    for each in motion.relations(units[basis].factor) if basis else ():
        total += min((math.log(_with(each, units)) / each.spread) ** 2, MOST)
    return total


def _with(seen: Seen, units: Mapping[str, Unit]) -> float:
    return seen.ratio * math.prod(units[name].factor ** power for name, power in seen.powers.items())


def _explained(
    motion: Motion, basis: str | None, name: str, best: Mapping[str, Unit], other: tuple[float, Unit] | None
) -> Chosen:
    unit = best[name]
    if unit.stated:
        return Chosen(unit, f"{shown(unit)}: the file states it", True)
    if other is None:
        return _alone(unit)
    margin, rival = other
    tied = [each for each in (motion.relations(best[basis].factor) if basis else ()) if name in each.powers]
    if margin < DECISIVE or not tied:
        return Chosen(unit, f"{shown(unit)}: assumed, {shown(rival)} is possible too: check", False)
    first = min(tied, key=lambda each: abs(math.log(_with(each, best))) / each.spread)
    ratios = [_with(first, {**best, name: each}) for each in (unit, rival)]
    reason = f"{shown(unit)}: {first.words} is {ratios[0]:.2g}, with {shown(rival)} {ratios[1]:.2g}"
    return Chosen(unit, reason, True)


def _beside(motion: Motion, name: str, units: tuple[Unit, ...], basis: Chosen | None) -> Chosen:
    """The unit of a signal without a relation: of a further speed by comparison with the basis, else the usual one."""
    if units[0].stated:
        return Chosen(units[0], f"{shown(units[0])}: the file states it", True)
    speed = motion.speed()
    is_speed = name == "vehicle_speed" or name.startswith("wheel_speed_")
    sure = len(units) > 1 or (basis is not None and basis.decided)
    if is_speed and sure and basis is not None and speed is not None and name in motion.columns:
        both = compared(motion.columns[name], speed, SECONDS * RATE)
        ratio = float(both.means[0] / both.means[1]) if both is not None and both.means[1] else math.nan
        if math.isfinite(ratio) and ratio > 0.0:
            off = [abs(math.log(ratio * each.factor / basis.unit.factor)) for each in units]
            at = int(np.argmin(off))
            if off[at] < 0.2:
                reason = f"{shown(units[at])}: agrees with the other wheel speeds within {100 * off[at]:.0f} %"
                return Chosen(units[at], reason, basis.decided)
    if len(units) == 1:
        return _alone(units[0])
    return Chosen(units[0], f"{shown(units[0])}: assumed, {shown(units[1])} is possible too: check", False)


def _alone(unit: Unit) -> Chosen:
    """The only candidate; a unit beyond the usual ones is a question to the reader."""
    if unit.name == COUNT:
        return Chosen(unit, "the values are plausible in no usual unit: check, and give the unit", False)
    if unit.turns:
        return Chosen(unit, f"{shown(unit)}? As a speed the values are implausible: check", False)
    return Chosen(unit, f"{shown(unit)}: the only one in which the values are plausible", True)


def shown(unit: Unit) -> str:
    return f"{unit.name} of the wheel, radius {RADIUS:g} m" if unit.turns else written(unit.name) or "no unit"
