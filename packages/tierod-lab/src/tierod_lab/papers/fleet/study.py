"""The study of fleets: the errors of the friction monitor, then vehicle-years and batches drawn from them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.content import Chart, Item, Lines, Panel, Table
from tierod.fleet.trends import Design, trends
from tierod.methods.trends.change_evidence import DAYS_PER_YEAR
from tierod.monitors.diagnose import diagnose
from tierod.monitors.friction.definition import FrictionMonitor
from tierod.vehicles import load
from tierod_lab.fleet.estimates import ErrorLaw, error_law, estimates, series
from tierod_lab.fleet.virtual import SECONDS_PER_DAY, Ageing, FleetFile, Group, Linear, Sudden, drawn
from tierod_lab.fleet.writing import VirtualDrive
from tierod_lab.papers.seeds import ReportedSeeds
from tierod_lab.studies import engine
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame, Row

YEARS, BATCHES, DRIVEN = "vehicle-years", "batches", "cars that are driven"
SEEDS = ReportedSeeds(
    lambda: (FrictionMonitor.of_vehicle(load("midsize-eps"), 0.01),),
    {YEARS: 0, BATCHES: 10_000, DRIVEN: 20_000},
    "the friction monitor of midsize-eps",
)

FRICTIONS = (4.0, 4.0, 4.0, 4.5, 5.0, 6.0)  # True friction of the drives of each car on each set of tyres [N*m]


def _drives(effort: Effort) -> list[VirtualDrive]:
    """Drives of five minutes of sixteen cars."""
    cars = range(3 if effort.quick else 16)
    first = SEEDS.of(DRIVEN, 1000 * (1 + len(cars)))[0]
    return [
        VirtualDrive(first + car, first + 1000 * (car + 1) + 100 * winter + number, friction, 300.0, bool(winter))
        for car in cars
        for winter in (0, 1)
        for number, friction in enumerate(FRICTIONS)
    ]


def over_drives(task: VirtualDrive) -> list[Row]:
    """Estimates of the friction monitor over drives of five minutes; load, tyres, pressure and zeros differ.

    All fleets below are at estimate level: their drives are not driven, but drawn from the errors of these.
    """
    estimate = diagnose(task.recording(), "midsize-eps", monitor="friction").findings[0].estimate
    value, stated = (math.nan, math.nan) if estimate is None else (estimate.value, estimate.standard_deviation)
    known = {"car": float(task.car), "winter": float(task.winter), "friction": task.friction}
    return [{**known, "estimate": value, "stated": stated, "error": value - task.friction}]


@cache
def law(effort: Effort) -> ErrorLaw:
    """Law of the errors of the driven cars."""
    rows = [row for made in effort.made(over_drives, _drives(effort)) for row in made]
    errors = Frame.of("errors", rows)
    return error_law(*(errors[name] for name in ("car", "winter", "friction", "estimate", "stated")))


RAMP, STEP = 0.01 / SECONDS_PER_DAY, 1.0  # Fault magnitudes: a ramp of 1 N*m per 100 days [N*m/s], and a step [N*m]
BEGIN = (90.0 * SECONDS_PER_DAY, 270.0 * SECONDS_PER_DAY)  # Earliest and latest start of a change [s]
CHANGES = {
    "none": (),
    "ramp": (Ageing("ramp", Linear(RAMP), 0.05, BEGIN),),
    "step": (Ageing("step", Sudden(STEP), 0.05, BEGIN),),
}
"""Changes of one car in twenty."""

TYRES: Annotated[float, "N*m"] = 0.03
"""Standard deviation, over cars, of the shift of the estimate by other tyres in the strict count of false alarms.

It equals the scatter of a single drive and is twice the largest value that sixteen driven cars have shown.
"""


class Years(NamedTuple):
    """A virtual fleet that is watched for 53 weeks."""

    law: ErrorLaw
    seed: int
    cars: int
    per_week: int  # drives of each car per week
    change: str = "none"  # name in `CHANGES`
    other_tyres: bool = False  # whether other tyres move the estimate of each car


def years(law: ErrorLaw, effort: Effort) -> list[Years]:
    """Fleets with one, two and seven drives a week, without changes, with ramps and with steps."""
    first, cars = SEEDS.of(YEARS, 1)[0], 200 if effort.quick else 10_000
    often = (1, 2, 7)
    made = [Years(law, first + 10 * n + more, cars, n, change) for more, change in enumerate(CHANGES) for n in often]
    strict = replace(law, winter=0.0, winter_deviation=TYRES)
    return [*made, Years(strict, first + 99, cars, often[-1], other_tyres=True)]


def over_years(task: Years) -> list[Row]:
    """The trends of the product over a year of each car, with seasons, winter tyres, mileage and wrong drives.

    False alarms are first alarms of cars before a change or without one. The design is at most one in 10 000
    vehicle-years. Shifts of fault-free levels, such as of other tyres, count as normally distributed; one of more than
    five deviations still stands out.
    """
    file = FleetFile("study", task.cars, "2025-01-01", seed=task.seed, weeks=53, drives_per_week=task.per_week,
                     ageing=CHANGES[task.change])  # fmt: skip
    cars = drawn(file)
    found = trends(series(cars, *estimates(cars, task.law, (task.seed, 9))), Design())
    changed = np.isfinite(cars.begin)
    first = cars.day.min(axis=1)
    # A changed car contributes fault-free time up to its change; an alarm before the change is false.
    end = np.where(changed, np.maximum(cars.begin, first), cars.day.max(axis=1))
    before = np.where(changed, found.alarmed < cars.begin, np.isfinite(found.alarmed))
    delays = np.where(np.isfinite(found.alarmed), found.alarmed - cars.begin, np.inf)[changed & ~before]
    listed = max(int(found.listed.sum()), 1)
    counted = {
        "years": float((end - first).sum()) / DAYS_PER_YEAR,
        "alarms": float(before.sum()),
        "wrong_share": float((found.listed & ~changed).sum()) / listed,
    }
    fleet: Row = {"per_week": float(task.per_week), "change": task.change, "other_tyres": float(task.other_tyres)}
    return [{**fleet, **counted}, *({**fleet, "delay": float(each), "within": float(each <= 30.0)} for each in delays)]


ODD = "2025-47"  # Name of the batch that may differ
BATCH = 0.02  # Share of the cars in a batch


class Fleet(NamedTuple):
    """A virtual fleet with one batch of 20 cars in 1 000 that may differ."""

    law: ErrorLaw
    friction: float  # excess friction of the batch `ODD` [N*m]
    seed: int


def fleets(law: ErrorLaw, effort: Effort) -> list[Fleet]:
    """Fleets for each size of the difference."""
    first, count = SEEDS.of(BATCHES, 1)[0], 3 if effort.quick else 50
    return [Fleet(law, size, first + number) for size in (1.0, 0.5, 0.25, 0.0) for number in range(count)]


def over_fleets(task: Fleet) -> list[Row]:
    """Cohorts of three kinds after four weekly drives of each car, with prior odds of 1 to 99."""
    others = tuple(Group("rack batch", f"2025-{week:02d}", BATCH) for week in range(1, 47))
    kinds = (Group("supplier", "A", 0.5), Group("climate", "north", 0.3, warmer=-6.0))
    groups = (Group("rack batch", ODD, BATCH, task.friction), *others, *kinds)
    cars = drawn(FleetFile("batch", 1000, "2026-01-05", seed=task.seed, weeks=4, groups=groups))
    found = trends(series(cars, *estimates(cars, task.law, (task.seed, 9))), Design()).cohorts.cohorts
    assert found is not None
    own = next(each for each in found.all if each.name == ODD)
    return [
        {
            "higher by": task.friction,
            "named": float(found.all[0].name == ODD and own.log_odds > 0.0),
            "log10_odds": own.log_odds / math.log(10.0),
            "others": float(sum(each.log_odds > 0.0 for each in found.all if each.name != ODD)),
            "effect": own.effect,
        }
    ]


def charts(frames: Mapping[str, Frame], effort: Effort) -> Iterator[Chart]:
    """How soon ramps are found."""
    along, marks = np.arange(0.0, 61.0), []
    for (often,), rows in frames["years"].where({"change": "ramp", "delay": ">= 0"}).groups("per_week"):
        marks.append(Lines(f"{often:g} a week", along, [float(np.mean(rows["delay"] <= day)) for day in along]))
    panel = Panel("", "days since the ramp began", "share of cars found", tuple(marks), uprights=(("30 days", 30.0),))
    title = "How soon a ramp of 1 N·m per 100 days is found"
    read = "Share of cars with a ramp that have raised an alarm, over the days since it began"
    yield Chart("ramps", title, "By drives of five minutes a week.", read, (panel,))


DATASETS = (
    Dataset("errors", "Errors of the friction monitor", over_drives, _drives),
    Dataset("years", "False alarms and delays", over_years, lambda effort: years(law(effort), effort)),
    Dataset("batches", "Batches of 20 cars in 1 000", over_fleets, lambda effort: fleets(law(effort), effort)),
)
"""The datasets, in the order of the report."""


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress, charts)
    figures = tuple((name.replace("_", " "), f"{value:.4g}") for name, value in asdict(law(effort)).items())
    yield Table("Law of the errors, from which fleets are drawn (N·m)", ("part", "figure"), figures)
    yield SEEDS.table()
