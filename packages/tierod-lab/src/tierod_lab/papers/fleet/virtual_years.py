"""Fleets at estimate level: false alarms on fault-free vehicle-years, and detection delay of ramps and steps."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Chart, Item, Lines, Panel, Table
from tierod.fleet.trends import Design, Trends, trends
from tierod.methods.trends.change_evidence import DAYS_PER_YEAR
from tierod_lab.campaign.figures import rate_bound
from tierod_lab.fleet.ageing import SECONDS_PER_DAY, Ageing, Linear, Sudden
from tierod_lab.fleet.estimates import ErrorLaw, estimates, series
from tierod_lab.fleet.virtual import FleetFile, VirtualCars, drawn
from tierod_lab.studies.effort import Effort

CARS, QUICK_CARS = 10_000, 200  # Cars of a fleet in full and in the quick study
WEEKS = 53  # Weeks that a fleet is watched
PER_WEEK = (1, 2, 7)  # Drives of five minutes per car and week, one fleet for each number

RAMP, STEP = 0.01 / SECONDS_PER_DAY, 1.0  # Fault magnitudes: a ramp of 1 N*m per 100 days [N*m/s], and a step [N*m]

BEGIN = (90.0 * SECONDS_PER_DAY, 270.0 * SECONDS_PER_DAY)  # Earliest and latest start of a change [s]
CHANGED = 0.05  # Share of cars that change in the fleets with changes

TYRES: Annotated[float, "N*m"] = 0.03
"""Standard deviation, over cars, of the shift of the estimate by other tyres in the strict count of false alarms.

It equals the scatter of a single drive and is twice the largest value that sixteen driven cars have shown.
"""

SHIFTED = (
    "Shifts of fault-free levels, such as of other tyres, count as normally distributed; one of more than five "
    "deviations still stands out."
)
"""Part of the cause of false alarms beyond the design."""

WITHIN = 30.0  # Required detection delay of a ramp [d]
GOAL = "goal of tierod"


@dataclass(frozen=True)
class Years:
    """A virtual fleet that is watched for a year."""

    per_week: int  # drives of each car per week
    cars: int  # number of cars
    law: ErrorLaw  # errors of the friction monitor
    seed: int  # seed of all random numbers
    ageing: tuple[Ageing, ...] = ()  # changes of a share of the cars; empty for a fault-free fleet

    def run(self) -> tuple[VirtualCars, Trends]:
        """Draw the cars and their estimates, and evaluate the trends of the product on them."""
        file = FleetFile("study", self.cars, "2025-01-01", seed=self.seed, weeks=WEEKS, drives_per_week=self.per_week,
                         ageing=self.ageing)  # fmt: skip
        cars = drawn(file)
        return cars, trends(series(cars, *estimates(cars, self.law, (self.seed, 9))), Design())


@dataclass(frozen=True)
class Counted:
    """False alarms and detection delays of one fleet."""

    years: float  # fault-free vehicle-years that were watched
    alarms: int  # false alarms: first alarms of cars before a change or without one
    # time from each change without an earlier alarm to its alarm [d]; infinite where there was none
    delays: tuple[float, ...]
    wrong_share: float  # share of fault-free cars in the list of changed cars at the end
    listed: int  # number of cars in that list


def counted(task: Years) -> Counted:
    """Run one fleet, and count its false alarms and detection delays."""
    cars, found = task.run()
    changed = np.isfinite(cars.begin)
    first = cars.day.min(axis=1)
    # A changed car contributes fault-free time up to its change; an alarm before the change is false.
    end = np.where(changed, np.maximum(cars.begin, first), cars.day.max(axis=1))
    before = np.where(changed, found.alarmed < cars.begin, np.isfinite(found.alarmed))
    delay = np.where(np.isfinite(found.alarmed), found.alarmed - cars.begin, np.inf)[changed & ~before]
    listed = int(found.listed.sum())
    wrong = int((found.listed & ~changed).sum())
    years = float((end - first).sum()) / DAYS_PER_YEAR
    return Counted(years, int(before.sum()), tuple(map(float, delay)), wrong / max(listed, 1), listed)


def items(law: ErrorLaw, effort: Effort, seed: int) -> Iterator[Item]:
    count = QUICK_CARS if effort.quick else CARS
    ramp = Ageing("ramp", Linear(RAMP), CHANGED, BEGIN)
    step = Ageing("step", Sudden(STEP), CHANGED, BEGIN)
    tasks = [Years(n, count, law, seed + 10 * n) for n in PER_WEEK]
    tasks += [
        replace(tasks[number], seed=tasks[number].seed + more, ageing=(ageing,))
        for number in range(len(PER_WEEK))
        for more, ageing in ((1, ramp), (2, step))
    ]
    other = replace(tasks[len(PER_WEEK) - 1], seed=seed + 99, law=with_tyres(law, TYRES))
    *found, tyres = effort.made(counted, [*tasks, other])
    quiet, ramps, steps = found[: len(PER_WEEK)], found[len(PER_WEEK) :: 2], found[len(PER_WEEK) + 1 :: 2]
    yield _quiet_table(quiet, tyres)
    yield _delay_table(ramps, steps)
    yield _delay_chart(ramps)
    yield from _claims(quiet, ramps, steps)
    often = f"{PER_WEEK[-1]} drives a week, other tyres moving the estimate by {TYRES:g} N·m"
    yield _false_alarms("tyres", often, tyres)


def with_tyres(law: ErrorLaw, deviation: float) -> ErrorLaw:
    """The law of errors of cars whose winter tyres shift the estimate; with 0 the errors of drives are independent.

    Args:
        deviation: standard deviation of that shift over the cars [N*m]
    """
    return replace(law, winter=0.0, winter_deviation=deviation)


def upper_bound(alarms: int) -> float:
    """Upper limit of the mean number of alarms at 95 % confidence, one-sided (Garwood, 1936)."""
    from scipy.stats import chi2

    return float(0.5 * chi2.ppf(0.95, 2 * alarms + 2))


def _quiet_table(quiet: list[Counted], tyres: Counted) -> Table:
    kinds = (*map(str, PER_WEEK), f"{PER_WEEK[-1]}, other tyres by {TYRES:g} N·m")
    rows = tuple(
        (
            kind,
            f"{each.years:.0f}",
            str(each.alarms),
            f"{1e4 * upper_bound(each.alarms) / each.years:.1f}",
            str(each.listed),
        )
        for kind, each in zip(kinds, (*quiet, tyres), strict=True)
    )
    return Table(
        "False alarms of fault-free cars, estimate level",
        ("drives a week", "vehicle-years", "alarms", "per 10 000 years, at most", "listed at the end"),
        rows,
        "With seasons, winter tyres, mileage, wrong drives and cars that differ. Designed for one alarm in 10 000 "
        "vehicle-years at the most; 'at most' is the bound of 95 % confidence on what was counted. In "
        "the last row a change of tyres moves the estimate of a car by more than the virtual tyres do, for months.",
    )


def _delay_table(ramps: list[Counted], steps: list[Counted]) -> Table:
    rows = tuple(
        (
            kind,
            str(n),
            str(len(each.delays)),
            *(f"{quantile(each, share):.0f}" for share in (0.5, 0.9, 0.95)),
            f"{within(each):.3f}",
            f"{each.wrong_share:.3f} of {each.listed}",
        )
        for kind, kinds in (("1 N·m per 100 d", ramps), ("step of 1 N·m", steps))
        for n, each in zip(PER_WEEK, kinds, strict=True)
    )
    header = (
        "change",
        "drives a week",
        "cars",
        "median [d]",
        "90 % [d]",
        "95 % [d]",
        "within 30 d",
        "wrong in the list",
    )
    return Table("Time from the begin of a change to its alarm, estimate level", header, rows)


def _delay_chart(ramps: list[Counted]) -> Chart:
    along = np.arange(0.0, 61.0)
    marks = tuple(
        Lines(f"{n} a week", along, [float(np.mean(np.array(each.delays) <= day)) for day in along])
        for n, each in zip(PER_WEEK, ramps, strict=True)
    )
    panel = Panel("", "days since the ramp began", "share of cars found", marks, uprights=(("30 days", WITHIN),))
    return Chart(
        "ramps", "How soon a ramp of 1 N·m per 100 days is found", "By drives of five minutes a week.",
        "Share of cars with a ramp that have raised an alarm, over the days since it began", (panel,),
    )  # fmt: skip


def quantile(each: Counted, share: float) -> float:
    """Quantile of the detection delay: the delay that a share of the cars does not exceed [d]."""
    delays = np.sort(each.delays)
    return float(delays[min(math.ceil(share * len(delays)), len(delays)) - 1]) if len(delays) else math.nan


def within(each: Counted) -> float:
    """Share of changes detected within `WITHIN` days."""
    return float(np.mean(np.array(each.delays) <= WITHIN)) if each.delays else math.nan


def _false_alarms(key: str, often: str, of: Counted) -> Claim:
    return Claim(
        f"ramps.false-alarms-{key}", f"At most one false alarm in 10 000 vehicle-years, {often}.", GOAL, None,
        1e4 * of.alarms / of.years, at_most(1.0), "",
        f"{of.alarms} counted on {of.years:.0f} vehicle-years at estimate level.",
        cause=f"{of.alarms} alarms of {of.years:.0f} years: their bound at 95 % is "
        f"{1e4 * rate_bound(of.alarms, of.years):.1f} in 10 000. {SHIFTED}",
    )  # fmt: skip


def _claims(quiet: list[Counted], ramps: list[Counted], steps: list[Counted]) -> Iterator[Claim]:
    for n, none, ramp in zip(PER_WEEK, quiet, ramps, strict=True):
        often = f"{n} drive{'s' * (n > 1)} of 5 minutes a week"
        note = f"{len(ramp.delays)} ramps; 95 % within {quantile(ramp, 0.95):.0f} d."
        yield _false_alarms(str(n), often, none)
        yield Claim(
            f"ramps.median-{n}", f"A ramp of 1 N·m per 100 days is found within 30 days, median, {often}.", GOAL, None,
            quantile(ramp, 0.5), at_most(WITHIN), "d", note,
        )  # fmt: skip
        yield Claim(
            f"ramps.within-{n}", f"A ramp of 1 N·m per 100 days is found within 30 days in 95 % of the cars, {often}.",
            GOAL, None, within(ramp), at_least(0.95),
            cause=f"95 % are found within {quantile(ramp, 0.95):.0f} d: a drive a week brings "
            f"{WITHIN / 7.0 * n:.0f} estimates in that time. More drives, or a lower threshold at more false alarms, "
            "would mend it.",
        )  # fmt: skip
    wrong = max(each.wrong_share for each in (*ramps, *steps))
    yield Claim(
        "ramps.wrong-share", "At most a tenth of the cars in the list of changed ones is wrong.", GOAL, None, wrong,
        at_most(0.1), "", "Largest of six fleets, at the end of the year.",
    )  # fmt: skip
