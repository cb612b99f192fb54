"""Ranking of the cars to inspect, the worst first, each with reasons and parts to inspect."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from tierod.fleet.standing import Standing
from tierod.fleet.trends import Trends
from tierod.methods.trends.change_evidence import RAMP


class Urgency(IntEnum):
    """Urgency of a car in the list; the lowest number comes first."""

    FAULT = 1
    SOON = 2
    CHANGED = 3
    LISTED = 4
    NEAR = 5


WORDS = {
    Urgency.FAULT: "fault",
    Urgency.SOON: "limit soon",
    Urgency.CHANGED: "changed",
    Urgency.LISTED: "probably changed",
    Urgency.NEAR: "near the limit",
}

SURE, POSSIBLE = 0.5, 0.05
"""Probability of reaching the limit soon from which a changed car is urgent, and from which any car is listed."""

INSPECT = {
    "friction torque at the steering wheel axis": (
        "the steering gear's grease, rack bush and yoke, and the joints of the column; a rise after a winter points to "
        "corrosion under a torn boot",
        "the rack for a bend, the gear for a broken bearing, and the joints of the column for one that binds",
    )
}
"""Quantity, and the parts to inspect after a drift and after a jump."""


@dataclass(frozen=True)
class Reason:
    """One reason for a car to be in the list.

    Args:
        urgency: urgency of the reason
        text: one sentence
        inspect: parts to inspect
        trends: underlying trends, with the index of the car in them; None if it rests on verdicts
        rows: rows of the underlying findings
        weight: order among reasons of the same urgency, the largest first
    """

    urgency: Urgency
    text: str
    inspect: str
    trends: tuple[Trends, int] | None = None
    rows: tuple[int, ...] = ()
    weight: float = 0.0


@dataclass(frozen=True)
class Ranked:
    """A car in the list.

    Args:
        vehicle: name of the car
        reasons: reasons, the most urgent first
    """

    vehicle: str
    reasons: tuple[Reason, ...] = field(repr=False)

    @property
    def urgency(self) -> Urgency:
        """Urgency of the first reason."""
        return self.reasons[0].urgency


def ranked(trends: Sequence[Trends], standing: Iterable[Standing]) -> list[Ranked]:
    """All cars with a reason for an inspection, the worst first.

    Args:
        trends: trends of all quantities
        standing: persistent faults
    """
    reasons: dict[str, list[Reason]] = {}
    for each in standing:
        reasons.setdefault(each.vehicle, []).append(_of_standing(each))
    for series in trends:
        for car in np.flatnonzero(_named(series)):
            reasons.setdefault(series.series.vehicles[car], []).append(_of_trend(series, int(car)))
    cars = [
        Ranked(vehicle, tuple(sorted(found, key=lambda each: (each.urgency, -each.weight))))
        for vehicle, found in reasons.items()
    ]
    return sorted(cars, key=lambda car: (car.urgency, -car.reasons[0].weight, car.vehicle))


def beyond(trends: Trends) -> np.ndarray:
    """Whether the estimated level of each car has reached its limit, (cars,)."""
    side = trends.learnt.changes.side
    with np.errstate(invalid="ignore"):
        return np.asarray(side * trends.level[:, 0] >= side * trends.series.limit)


def _named(trends: Trends) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        near = trends.chance >= POSSIBLE
    return np.asarray(trends.listed | np.isfinite(trends.alarmed) | near | beyond(trends))


def _of_standing(each: Standing) -> Reason:
    thing = each.judged or f"monitor {each.monitor}"
    kind = f" ({each.kind})" if each.kind else ""
    text = f"{thing}: fault{kind} in {each.faults} of the last {each.of} judged drives"
    part = f"{each.judged.replace('_', ' ')}, its plug and its wiring" if each.judged else ""
    inspect = each.action or part or "the parts that the reports of these drives name"
    return Reason(Urgency.FAULT, text, inspect, None, each.rows, each.faults / each.of)


def _of_trend(trends: Trends, car: int) -> Reason:
    alarmed, chance = math.isfinite(trends.alarmed[car]), float(trends.chance[car])
    changed = alarmed or bool(trends.listed[car])
    if bool(beyond(trends)[car]):
        urgency = Urgency.FAULT
    elif changed and chance >= SURE:
        urgency = Urgency.SOON
    elif changed:
        urgency = Urgency.CHANGED if alarmed else Urgency.LISTED
    else:
        urgency = Urgency.NEAR
    quantity = trends.series.watched.quantity
    drift, jump = INSPECT.get(quantity, (f"the parts that change the {quantity}",) * 2)
    # A shift found in spring is as likely corrosion that swelled within weeks as a broken part.
    ramp = int(trends.kind[car]) == RAMP or date(trends.latest[car])[5:7] in ("03", "04", "05")
    text = _change_text(trends, car) if changed else _near_text(trends, car)
    rows = tuple(int(row) for row in _notable_drives(trends, car, changed))
    weight = (chance if math.isfinite(chance) else 0.0) + 1e-3 * max(float(trends.logarithm[car]), 0.0)
    return Reason(urgency, text, drift if ramp or not changed else jump, (trends, car), rows, weight)


def _change_text(trends: Trends, car: int) -> str:
    size, unit = trends.size[car], trends.series.watched.unit.replace("*", "·")
    if int(trends.kind[car]) == RAMP:
        what = f"changes by {100.0 * size[0]:+.2g} ± {196.0 * size[1]:.1g} {unit} per 100 days"
    else:
        what = f"shifted by {size[0]:+.2g} ± {1.96 * size[1]:.1g} {unit}"
    return f"{trends.series.watched.quantity} {what} since {date(trends.began[car])}"


def _near_text(trends: Trends, car: int) -> str:
    level, limit, unit = trends.level[car, 0], trends.series.limit[car], trends.series.watched.unit.replace("*", "·")
    return f"{trends.series.watched.quantity} is {level:.3g} {unit}, limit {limit:.3g} {unit}, without a change found"


def _notable_drives(trends: Trends, car: int, changed: bool) -> np.ndarray:
    """Rows of up to eight drives that show the reason: those since the change, the newest first."""
    rows, day = trends.series.row[car], trends.series.drives.day[car]
    there = rows >= 0
    since = there & (day > trends.began[car]) if changed else there
    return np.asarray(rows[since if since.any() else there][::-1][:8])


def date(day: float) -> str:
    """A day since 1970 as a date; a dash if it is not finite."""
    import datetime as dt

    return str(dt.date(1970, 1, 1) + dt.timedelta(days=math.floor(day))) if math.isfinite(day) else "–"
