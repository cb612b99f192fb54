"""Ranking of the cars to inspect, the worst first, each with reasons and parts to inspect."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from tierod.core.statuses import Status, worst
from tierod.fleet.standing import JUDGED, LAST, Drive, Standing, counted, drives_in_words
from tierod.fleet.trends import Trends
from tierod.methods.trends.change_evidence import RAMP


class Urgency(IntEnum):
    """Urgency of a car in the list; the lowest number comes first."""

    FAULT = 1
    CONFIRM = 2
    SOON = 3
    CHANGED = 4
    LISTED = 5
    NEAR = 6


WORDS = {
    Urgency.FAULT: "fault",
    Urgency.CONFIRM: "to confirm",
    Urgency.SOON: "limit soon",
    Urgency.CHANGED: "changed",
    Urgency.LISTED: "probably changed",
    Urgency.NEAR: "near the limit",
}

SURE, POSSIBLE = 0.5, 0.05
"""Probability of reaching the limit soon from which a changed car is urgent, and from which any car is listed."""

SHOWN = 2
"""Number of reasons of a car in the list; its own section and the JSON document have all."""

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
        trends: trends of the quantity, with the index of the car in them; None if it is not followed
        rows: rows of the underlying findings, the newest first
        to_confirm: drives that are not healthy, but not enough for a persistent fault
        weight: order among reasons of the same urgency, the largest first
    """

    urgency: Urgency
    text: str
    inspect: str
    trends: tuple[Trends, int] | None = None
    rows: tuple[int, ...] = ()
    to_confirm: tuple[Drive, ...] = ()
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

    @property
    def to_confirm(self) -> tuple[Status, ...]:
        """Worst verdict of each drive that is to be confirmed; empty for a car in another state."""
        if self.urgency is not Urgency.CONFIRM:
            return ()
        drives: dict[object, Status] = {}
        for each in (drive for reason in self.reasons for drive in reason.to_confirm):
            key = each.name or each.row
            drives[key] = worst((drives.get(key, each.status), each.status))
        return tuple(drives.values())

    @property
    def state(self) -> str:
        """State in words: "to confirm: 1 fault, 1 suspect"."""
        word = WORDS[self.urgency]
        return f"{word}: {counted(self.to_confirm)}" if self.to_confirm else word

    @property
    def why(self) -> str:
        """The first reasons in words."""
        return "; ".join(each.text for each in self.reasons[:SHOWN])

    @property
    def inspect(self) -> str:
        """The parts or drives to inspect for these reasons."""
        return "; ".join(dict.fromkeys(each.inspect for each in self.reasons[:SHOWN]))


def ranked(trends: Sequence[Trends], standing: Iterable[Standing]) -> list[Ranked]:
    """All cars with a reason for an inspection, the worst first.

    Args:
        trends: trends of all quantities
        standing: verdicts of the last judged drives
    """
    reasons: dict[str, list[Reason]] = {}
    followed = {
        (vehicle, series.series.watched.monitor, series.series.watched.judged): (series, car)
        for series in trends
        for car, vehicle in enumerate(series.series.vehicles)
    }
    for each in standing:
        if each.drives:
            trend = followed.get((each.vehicle, each.monitor, each.judged))
            reasons.setdefault(each.vehicle, []).append(_of_standing(each, trend))
    for series in trends:
        for car in np.flatnonzero(_named(series)):
            reasons.setdefault(series.series.vehicles[car], []).append(_of_trend(series, int(car)))
    cars = [
        Ranked(vehicle, tuple(sorted(found, key=lambda each: (each.urgency, -each.weight))))
        for vehicle, found in reasons.items()
    ]
    return sorted(cars, key=lambda car: (car.urgency, -car.reasons[0].weight, car.vehicle))


def beyond(trends: Trends) -> np.ndarray:
    """Whether the estimated level of each car has reached its limit, (cars,).

    The level rests on as many drives as the verdicts: a shorter one is left to these.
    """
    side = trends.learnt.changes.side
    with np.errstate(invalid="ignore"):
        return np.asarray((side * trends.level[:, 0] >= side * trends.series.limit) & (trends.held >= LAST))


def _named(trends: Trends) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        near = trends.chance >= POSSIBLE
    changed = [trends.changed(car) for car in range(len(trends.listed))]
    return np.asarray(np.array(changed, bool) | near | beyond(trends))


def _of_standing(each: Standing, trend: tuple[Trends, int] | None) -> Reason:
    rows = tuple(drive.row for drive in reversed(each.drives))
    action = each.action.removeprefix("inspect ")
    weight = sum(10.0 ** -JUDGED.index(drive.status) for drive in each.drives)
    if not each.persistent:
        listed = "; ".join(drive.text for drive in each.drives)
        found = counted(drive.status for drive in each.drives)
        text = f"{each.subject}: to confirm: {found} in {drives_in_words(each.of)} ({listed}){_level_text(trend)}"
        inspect = "these drives with 'tierod diagnose'" + (f"; {action}" if action else "")
        return Reason(Urgency.CONFIRM, text, inspect, trend, rows, each.drives, weight)
    kind = f" ({each.kind})" if each.kind else ""
    text = f"{each.subject}: fault{kind} in {each.faults} of {drives_in_words(each.of)}{_level_text(trend)}"
    part = f"{each.judged.replace('_', ' ')}, its plug and its wiring" if each.judged else ""
    inspect = action or part or "the parts that the reports of these drives name"
    return Reason(Urgency.FAULT, text, inspect, trend, rows, (), weight)


def _level_text(trend: tuple[Trends, int] | None) -> str:
    """Level of a car whose level stepped or may have stepped, as the end of a sentence; "" for any other."""
    if trend is None:
        return ""
    trends, car = trend
    unit = trends.series.watched.unit.replace("*", "·")
    if math.isfinite(last := trends.unconfirmed[car]):
        return f"; level {trends.level[car, 0]:.3g} {unit} before the last drive, which gave {last:.3g} {unit}"
    if math.isfinite(day := trends.stepped(car)):
        return f"; level {trends.level[car, 0]:.3g} {unit} since {date(day)}, {trends.before[car]:.3g} {unit} before"
    return ""


def _of_trend(trends: Trends, car: int) -> Reason:
    alarmed, chance = math.isfinite(trends.alarmed[car]), float(trends.chance[car])
    changed = trends.changed(car)
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
    return Reason(urgency, text, drift if ramp or not changed else jump, (trends, car), rows, (), weight)


def _change_text(trends: Trends, car: int) -> str:
    size, unit = trends.size[car], trends.series.watched.unit.replace("*", "·")
    if int(trends.kind[car]) == RAMP:
        what = f"changes by {100.0 * size[0]:+.2g} ± {196.0 * size[1]:.1g} {unit} per 100 days"
    else:
        what = f"shifted by {size[0]:+.2g} ± {1.96 * size[1]:.1g} {unit}"
    return f"{trends.series.watched.quantity} {what} since {date(trends.onset(car))}"


def _near_text(trends: Trends, car: int) -> str:
    limit, unit = trends.series.limit[car], trends.series.watched.unit.replace("*", "·")
    level, deviation = trends.stated(car)
    stepped = trends.stepped(car)
    since = f"since {date(stepped)}" if math.isfinite(stepped) else "without a change found"
    now = f"{level:.3g} ± {1.96 * deviation:.1g} {unit}"
    return f"{trends.series.watched.quantity} is {now}, limit {limit:.3g} {unit}, {since}"


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
