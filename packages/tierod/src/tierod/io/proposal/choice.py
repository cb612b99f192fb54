"""Choice of the unit of every column: the combination in which redundant signals agree best."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tierod.core.shown import written
from tierod.core.units import COUNT
from tierod.io.proposal.motion import RATE, SECONDS, STRONG, Motion, Relation
from tierod.io.proposal.units import RADIUS, Unit

# Smallest difference of the squared deviations at which a unit counts as decided: two standard deviations [-]
DECISIVE = 4.0

# Bound on the squared deviation of one relation [-], so that a signal with another fault does not decide all units
MOST = 25.0

# Cost of a unit per place in the list of candidates [-], so that the usual unit is chosen where nothing decides
WORSE = 0.3

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
    """The unit of every signal."""
    basis = motion.basis
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


def _cost(
    motion: Motion, basis: str | None, units: Mapping[str, Unit], possible: Mapping[str, tuple[Unit, ...]]
) -> float:
    total = WORSE * sum(possible[name].index(unit) for name, unit in units.items())
    for relation in motion.relations(units[basis].factor) if basis else ():
        if abs(relation.correlation) >= STRONG:
            total += min((math.log(_with(relation, units)) / relation.spread) ** 2, MOST)
    return total


def _with(relation: Relation, units: Mapping[str, Unit]) -> float:
    return relation.ratio * math.prod(units[name].factor ** power for name, power in relation.powers.items())


def _explained(
    motion: Motion,
    basis: str | None,
    name: str,
    best: Mapping[str, Unit],
    other: tuple[float, Unit] | None,
) -> Chosen:
    unit = best[name]
    if unit.stated:
        return Chosen(unit, f"{shown(unit)}: the file states it", True)
    if other is None:
        return _alone(unit)
    margin, rival = other
    related = [
        each
        for each in (motion.relations(best[basis].factor) if basis else ())
        if name in each.powers and abs(each.correlation) >= STRONG
    ]
    if margin < DECISIVE or not related:
        return Chosen(unit, f"{shown(unit)}: assumed, {shown(rival)} is possible too: check", False)
    first = min(related, key=lambda each: abs(math.log(_with(each, best))) / each.spread)
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
        ratio = _mean_ratio(motion.columns[name], speed)
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


def _mean_ratio(a: np.ndarray, b: np.ndarray) -> float:
    good = np.isfinite(a) & np.isfinite(b)
    if np.count_nonzero(good) < SECONDS * RATE or not float(np.mean(b[good])):
        return math.nan
    return float(np.mean(a[good]) / np.mean(b[good]))


def shown(unit: Unit) -> str:
    """A unit for display."""
    return f"{unit.name} of the wheel, radius {RADIUS:g} m" if unit.turns else written(unit.name) or "no unit"
