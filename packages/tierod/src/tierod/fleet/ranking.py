"""Ranking of the cars to inspect, the worst first, each with reasons and parts to inspect."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np

from tierod.core.shown import in_words, plus_minus
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

FALLEN = 0.75
"""Share of its level before, and of the nominal value, below which a level fell [-]: no ageing removes a quarter of it,
but a changed gain of a sensor does."""

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
    """One reason for a car to be in the list."""

    urgency: Urgency
    text: str
    inspect: str  # what to do: the parts to inspect, or the drives to look at
    # trends of the quantity, with the index of the car in them; None if it is not followed
    trends: tuple[Trends, int] | None = None
    rows: tuple[int, ...] = ()  # rows of the underlying findings, the newest first
    to_confirm: tuple[Drive, ...] = ()  # drives that are not healthy, but not enough for a persistent fault
    weight: float = 0.0  # order among reasons of the same urgency, the largest first

    def and_also(self, trend: Reason, text: str) -> Reason:
        """This reason together with the trend of the same quantity: one reason, as urgent as the more urgent one."""
        inspect = "; ".join(dict.fromkeys((*self.inspect.split("; "), *trend.inspect.split("; "))))
        return replace(
            self,
            urgency=min(self.urgency, trend.urgency),
            text="; ".join(filter(None, (self.text, text))),
            inspect=inspect,
            rows=tuple(dict.fromkeys((*self.rows, *trend.rows))),
            weight=self.weight + trend.weight,
        )


@dataclass(frozen=True)
class Ranked:
    """A car in the list."""

    vehicle: str
    reasons: tuple[Reason, ...] = field(repr=False)  # reasons, the most urgent first

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
            drives[each.key] = worst((drives.get(each.key, each.status), each.status))
        return tuple(drives.values())

    @property
    def state(self) -> str:
        """State in words: "to confirm: 1 fault, 1 suspect"."""
        word = WORDS[self.urgency]
        return f"{word}: {counted(self.to_confirm)}" if self.to_confirm else word

    @property
    def why(self) -> str:
        """The reasons in words, each once."""
        return "; ".join(dict.fromkeys(each.text for each in self.reasons))

    @property
    def inspect(self) -> str:
        """What to do for these reasons, each once."""
        return "; ".join(dict.fromkeys(part for each in self.reasons for part in each.inspect.split("; ")))


def ranked(trends: Sequence[Trends], standing: Iterable[Standing]) -> list[Ranked]:
    """All cars with a reason for an inspection, the worst first."""
    reasons: dict[str, dict[tuple[str, str], Reason]] = {}
    followed = {
        (vehicle, series.series.watched.monitor, series.series.watched.judged): (series, car)
        for series in reversed(trends)
        for car, vehicle in enumerate(series.series.vehicles)
    }
    for each in _distinct([each for each in standing if each.drives]):
        key = each.monitor, each.judged
        trend = followed.get((each.vehicle, *key))
        reasons.setdefault(each.vehicle, {})[key] = _of_standing(each, _level_text(trend), trend)
    for series in trends:
        key = series.series.watched[:2]
        for car in np.flatnonzero(_named(series)).tolist():
            of_car, reason = reasons.setdefault(series.series.vehicles[car], {}), _of_trend(series, car)
            before, day = of_car.get(key), series.stepped(car)
            # A level that stepped on the day of the change is said already.
            said = math.isfinite(day) and (not series.changed(car) or day == series.onset(car))
            said &= followed[series.series.vehicles[car], *key][0] is series
            of_car[key] = reason if before is None else before.and_also(reason, "" if said else reason.text)
    cars = [
        Ranked(vehicle, tuple(sorted(found.values(), key=lambda each: (each.urgency, -each.weight))))
        for vehicle, found in reasons.items()
    ]
    return sorted(cars, key=lambda car: (car.urgency, -car.reasons[0].weight, car.vehicle))


def _distinct(standing: Sequence[Standing]) -> list[Standing]:
    """Standings without those of a whole monitor of which its elements say as much: its drives, and as persistent."""
    by_elements: dict[tuple[str, str], dict[object, Status]] = {}
    persistent = {(each.vehicle, each.monitor) for each in standing if each.judged and each.persistent}
    for each in standing:
        if each.judged:
            known = by_elements.setdefault((each.vehicle, each.monitor), {})
            for drive in each.drives:
                known[drive.key] = worst((known.get(drive.key, drive.status), drive.status))

    def hidden(each: Standing) -> bool:
        known = by_elements.get(car := (each.vehicle, each.monitor), {})
        said = all(one.key in known and worst((known[one.key], one.status)) is known[one.key] for one in each.drives)
        return not each.judged and said and each.persistent <= (car in persistent)

    return [each for each in standing if not hidden(each)]


def beyond(trends: Trends) -> np.ndarray:
    """Whether the level of each car is beyond its limit by more than the deviation that its drives share, (cars,).

    The level rests on as many drives as the verdicts: a shorter one is left to these.
    """
    past = trends.learnt.changes.side * (trends.level[:, 0] - trends.series.limit)
    with np.errstate(invalid="ignore"):
        return np.asarray((past >= trends.series.shared) & (trends.held >= LAST))


def fallen(trends: Trends) -> np.ndarray:
    """Whether the level of each car stepped far below the old and the nominal one, away from the limit, (cars,).

    The nominal value counts because a level that falls back to it was repaired.
    """
    with np.errstate(invalid="ignore"):
        far = trends.level[:, 0] < FALLEN * np.fmin(trends.before, trends.series.nominal)
    return np.asarray(far & np.isfinite(trends.before) & (trends.learnt.changes.side > 0.0))


def _named(trends: Trends) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        near = trends.chance >= POSSIBLE
    changed = [trends.changed(car) for car in range(len(trends.listed))]
    return np.asarray(np.array(changed, bool) | near | beyond(trends) | fallen(trends))


def _of_standing(each: Standing, level: str, trend: tuple[Trends, int] | None) -> Reason:
    rows = tuple(drive.row for drive in reversed(each.drives))
    weight = sum(10.0 ** -JUDGED.index(drive.status) for drive in each.drives)
    if not each.persistent:
        alike = len({drive.status for drive in each.drives}) == 1
        listed = "; ".join(drive.place if alike else drive.text for drive in each.drives)
        found = counted(drive.status for drive in each.drives)
        text = f"{each.subject}: {found} in {drives_in_words(each.of)} ({listed}){level}"
        inspect = "look at these drives with 'tierod diagnose'" + (f"; {each.action}" if each.action else "")
        return Reason(Urgency.CONFIRM, text, inspect, trend, rows, each.drives, weight)
    fault = f"fault ({each.kind})" if each.kind else "fault"
    text = f"{each.subject}: {fault} in {each.faults} of {drives_in_words(each.of)}{level}"
    part = f"inspect {each.judged.replace('_', ' ')}, its plug and its wiring" if each.judged else ""
    inspect = each.action or part or "inspect the parts that the reports of these drives name"
    return Reason(Urgency.FAULT, text, inspect, trend, rows, (), weight)


def _level_text(trend: tuple[Trends, int] | None) -> str:
    """Level of a car whose level stepped or may have stepped, as the end of a sentence; "" for any other."""
    if trend is None:
        return ""
    trends, car = trend
    level, before, last = (
        in_words(value, trends.series.watched.unit)
        for value in (trends.level[car, 0], trends.before[car], trends.unconfirmed[car])
    )
    if math.isfinite(trends.unconfirmed[car]):
        return f"; level {level} before the last drive, which gave {last}"
    if math.isfinite(day := trends.stepped(car)):
        return f"; level {level} since {date(day)}, {before} before"
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
        urgency = Urgency.CONFIRM if fallen(trends)[car] else Urgency.NEAR
    quantity = trends.series.watched.quantity
    drift, jump = INSPECT.get(quantity, (f"the parts that change the {quantity}",) * 2)
    # A shift found in spring is as likely corrosion that swelled within weeks as a broken part.
    ramp = int(trends.kind[car]) == RAMP or date(trends.latest[car])[5:7] in ("03", "04", "05")
    text = _change_text(trends, car) if changed else _near_text(trends, car)
    what = f"inspect {drift if ramp or not changed else jump}"
    if urgency is Urgency.CONFIRM:
        level, before = (
            in_words(each, trends.series.watched.unit) for each in (trends.level[car, 0], trends.before[car])
        )
        text = f"{quantity} fell from {before} to {level} on {date(trends.stepped(car))}; a fault may be judged healthy"
        what = "check whether the gains of its sensors have changed since; judge a test on a bench or at standstill"
    rows = tuple(int(row) for row in _notable_drives(trends, car, changed))
    weight = (chance if math.isfinite(chance) else 0.0) + 1e-3 * max(float(trends.logarithm[car]), 0.0)
    return Reason(urgency, text, what, (trends, car), rows, (), weight)


def _change_text(trends: Trends, car: int) -> str:
    (size, deviation), unit = trends.size[car], trends.series.watched.unit
    if int(trends.kind[car]) == RAMP:
        what = f"changes by {plus_minus(100.0 * size, 100.0 * deviation, unit, signed=True)} per 100 days"
    else:
        what = f"shifted by {plus_minus(size, deviation, unit, signed=True)}"
    return f"{trends.series.watched.quantity} {what} since {date(trends.onset(car))}"


def _near_text(trends: Trends, car: int) -> str:
    unit, stepped = trends.series.watched.unit, trends.stepped(car)
    since = f"since {date(stepped)}" if math.isfinite(stepped) else "without a change found"
    now, limit = plus_minus(*trends.stated(car), unit), in_words(trends.series.limit[car], unit)
    return f"{trends.series.watched.quantity} is {now}, limit {limit}, {since}"


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
