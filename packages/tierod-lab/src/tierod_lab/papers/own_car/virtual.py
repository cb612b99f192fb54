"""Unknown virtual cars: coverage, error, false verdicts and processor time, by monitor and vehicle file."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, Goal, at_most, between, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.errors import InputError
from tierod.monitors.sideslip.tuning import CONSTANT_ERROR
from tierod.work.pool import Failure
from tierod_lab.papers.own_car.judging import (
    BROCHURE,
    ESTIMATES,
    FALSE,
    IDENTIFIED,
    TRUE,
    TRUTHS,
    Case,
    Judged,
    Studied,
)
from tierod_lab.papers.own_car.judging import studied as of_case
from tierod_lab.papers.own_car.reported import CARS as DRAWN
from tierod_lab.papers.own_car.reported import SEEDS
from tierod_lab.studies.effort import Effort, Progress

GOAL = "goal of tierod"
CARS, QUICK_CARS, THOROUGH_CARS = 7, 3, 20
"""Number of cars: one of every base car; the thorough study has nearly three of each, and drives each for two hours."""
MEASURED = 4  # Number of cars on which the processor time of the spread is measured
WIDE, NARROW = between(0.90, 0.98), between(0.92, 0.97)
"""Goals for the coverage of a 95 % band: before and after identification."""
MOST_WORSE, MOST_COST = 1.3, 4.0
"""Largest ratio of the errors after identification and with true parameters, and of processor times with spread."""
DEGREES = {"sideslip": math.degrees(1.0)}
"""Factor from the SI unit of an error to its unit in the tables, where they differ."""
UNITS = {"sideslip": "deg", "driver-torque": "N*m", "friction": "N*m", "motor-angle": "rad"}
"""Unit of the error of each monitor in the tables."""

TEXT = (
    "Cars drawn over the classes, quadricycle to van, front and rear drive, column and rack EPS. Of each its user "
    "knows mass (to 5 %) and wheelbase; all else is typical of the class, with its spread, as `tierod new` writes it. "
    "One drive identifies the car, other drives are judged with the file before, the file after, and with the true "
    "parameters. No monitor sees a truth. The seed follows from the monitors that are judged.",
)


class Pooled(NamedTuple):
    """One monitor with one vehicle file, over all cars."""

    samples: int  # number of compared samples
    coverage: float  # share of the samples with the truth in the 95 % band
    worst: float  # lowest coverage of a drive
    error: float  # root mean square error, in SI units
    false: int  # number of false verdicts
    drives: int  # number of judged drives
    unjudged: int  # number of drives without a compared estimate


def cases(effort: Effort, seed: int) -> list[Case]:
    """The cars of the study, and the length of their drives."""
    if effort.quick:
        return [Case(number, seed, 2.0, 2.5, 1, number == 0) for number in range(QUICK_CARS)]
    minutes, drives, cars = (30.0, 4, THOROUGH_CARS) if effort.thorough else (13.0, 1, CARS)
    return [Case(number, seed, 13.0, minutes, drives, number < MEASURED) for number in range(cars)]


def items(effort: Effort, progress: Progress, seed: int | None = None) -> Iterator[Item]:
    yield Heading("Virtual cars that are not known", TEXT)
    given = cases(effort, SEEDS.of(DRAWN, 1)[0] if seed is None else seed)
    found: dict[int, Studied] = {}
    for number, result in effort.outcomes(of_case, given):
        if isinstance(result, Failure):
            raise InputError(f"car {number + 1} of the study failed: {result.reason}")
        found[number] = result
        progress(len(found) / len(given), f"car {len(found)} of {len(given)}")
    yield from shown([found[number] for number in range(len(given))])


def shown(found: Sequence[Studied]) -> Iterator[Item]:
    """Tables and claims of judged cars."""
    judged = [each for car in found for each in car.judged]
    files = [name for name in (BROCHURE, IDENTIFIED, TRUE) if any(each.file == name for each in judged)]
    of = {(monitor, file): pooled(judged, monitor, file) for monitor in TRUTHS for file in files}
    yield table("Cars that are not known", of)
    yield _cars(found, files)
    yield _verdicts(judged)
    for monitor in ESTIMATES:
        yield from claims(monitor, of)
    if within := [each for car in found for each in car.within]:
        yield _of_parameters(within)
    for monitor in TRUTHS:
        yield from false_and_cost(monitor, judged, of)


def pooled(judged: Sequence[Judged], monitor: str, file: str) -> Pooled:
    """Pool the results of one monitor with one vehicle file over all cars.

    Args:
        judged: every monitor on every drive with every file
    """
    own = [each for each in judged if (each.monitor, each.file) == (monitor, file)]
    seen = [each for each in own if each.samples]
    count = sum(each.samples for each in seen)
    shares = [each.held / each.samples for each in seen]
    return Pooled(
        count,
        sum(each.held for each in seen) / count if count else math.nan,
        min(shares, default=math.nan),
        math.sqrt(sum(each.squares for each in seen) / count) if count else math.nan,
        sum(each.status in FALSE for each in own),
        len(own),
        len(own) - len(seen),
    )


def table(title: str, of: dict[tuple[str, str], Pooled]) -> Table:
    """Table of coverage, error and false verdicts."""
    rows = []
    for (monitor, file), each in of.items():
        factor = DEGREES.get(monitor, 1.0)
        estimates = monitor in UNITS
        rows.append(
            (
                monitor,
                file,
                str(each.drives),
                str(each.unjudged) if estimates else "",
                f"{100.0 * each.coverage:.1f} %" if estimates else "",
                f"{100.0 * each.worst:.0f} %" if estimates else "",
                f"{factor * each.error:.3g} {UNITS[monitor].replace('*', '·')}" if estimates else "",
                str(each.false),
            )
        )
    header = ("monitor", "vehicle file", "drives", "without estimate", "in the 95 % band", "worst car")
    return Table(title, (*header, "rms error", "false faults"), tuple(rows))


def _cars(found: Sequence[Studied], files: Sequence[str]) -> Table:
    rows = []
    for car in found:
        name = car.judged[0].car if car.judged else ""
        shares = []
        for monitor in ESTIMATES:
            own = [pooled(car.judged, monitor, file).coverage for file in files]
            shares.append(" / ".join("–" if math.isnan(each) else f"{100.0 * each:.0f}" for each in own))
        rows.append((name, *shares, ", ".join(car.learnt) or car.doubt.partition(":")[0], f"{car.seconds:.0f}"))
    header = ("car", *(f"{monitor} [%]" for monitor in ESTIMATES), "identified", "time [s]")
    return Table(f"Car by car: in the 95 % band ({' / '.join(files)})", header, tuple(rows))


def _verdicts(judged: Sequence[Judged]) -> Table:
    rows = tuple((each.car, each.monitor, each.file, each.headline) for each in judged if each.status in FALSE)
    return Table("False verdicts of a fault", ("car", "monitor", "vehicle file", "verdict"), rows or (("none",) * 4,))


NOT_SEEN = {
    "sideslip": (
        f" {math.degrees(CONSTANT_ERROR):.2f} degrees of it stand for axles and sensors that are not parallel, which "
        "real cars have, these have not, and no signal shows."
    )
}
"""Part of the band of an estimate that these cars cannot fill, as words of a cause."""


def _too(monitor: str, of: Pooled, goal: Goal, true: Pooled | None) -> str:
    if of.coverage <= goal.high:
        return f"{100.0 * of.worst:.0f} % on the worst of {of.drives} drives; a few cars decide."
    if true is not None and true.coverage > goal.high:
        return (
            f"Too wide: with the true parameters the band holds {100.0 * true.coverage:.1f} %, so that noises and "
            "errors of the model decide, not the spread of the parameters. Noises of the very car would mend it."
            f"{NOT_SEEN.get(monitor, '')}"
        )
    return (
        f"Too wide: the root mean square error is {of.error:.3g}, and the band covers what no drive has shown. "
        "Narrower priors, or more that a drive identifies, would mend it."
    )


def claims(monitor: str, of: dict[tuple[str, str], Pooled]) -> Iterator[Claim]:
    """Claims on coverage and error of a monitor's estimate."""
    brochure, true = of[monitor, BROCHURE], of.get((monitor, TRUE))
    yield Claim(
        f"unknown.{monitor}-band",
        f"Share of the truth in the 95 % band of {monitor}, by the brochure alone.",
        GOAL,
        None,
        brochure.coverage,
        WIDE,
        "",
        f"{brochure.worst:.2f} on the worst car.",
        cause=_too(monitor, brochure, WIDE, true),
    )
    own = of.get((monitor, IDENTIFIED))
    if own is None:
        return
    claim = f"Share of the truth in the 95 % band of {monitor}, after one drive has identified the car."
    note = f"{own.worst:.2f} on the worst car."
    cause = _too(monitor, own, NARROW, true)
    yield Claim(f"identified.{monitor}-band", claim, GOAL, None, own.coverage, NARROW, "", note, cause=cause)
    ratio = own.error / true.error if true is not None and true.error > 0.0 else math.nan
    before = brochure.error / true.error if true is not None and true.error > 0.0 else math.nan
    yield Claim(
        f"identified.{monitor}-error",
        f"Error of {monitor} after identification over that with the true parameters.",
        GOAL,
        None,
        ratio,
        at_most(MOST_WORSE),
        "",
        f"{before:.2f} by the brochure.",
        cause=f"Errors {own.error:.3g} identified, {brochure.error:.3g} by the brochure: one drive "
        "shows little of what moves this estimate.",
    )


def _of_parameters(within: Sequence[bool]) -> Claim:
    share = sum(within) / len(within)
    return Claim(
        "identified.parameters-band",
        "Share of the true values in the 95 % intervals of identified parameters.",
        GOAL,
        None,
        share,
        WIDE,
        "",
        f"{len(within)} parameters.",
        cause=f"{len(within) - sum(within)} of {len(within)} lie outside: the model of the motion lacks what a torsion "
        "bar yields, load transfer and the place of the inertial unit do; `MODEL_ERRORS` holds what they did on others."
        if share < WIDE.low
        else "The errors of the model count for every car as on the worst of those that they were taken from.",
    )


def false_and_cost(monitor: str, judged: Sequence[Judged], of: dict[tuple[str, str], Pooled]) -> Iterator[Claim]:
    """Claims on the false verdicts of a monitor, and on the processor time of the spread.

    Args:
        judged: every monitor on every drive with every file
    """
    drives = sum(each.drives for (name, _), each in of.items() if name == monitor)
    false = [each for each in judged if each.monitor == monitor and each.status in FALSE]
    claim = f"Verdicts of a fault by {monitor} on fault-free drives."
    by_car = ", ".join(f"{car} ({count})" for car, count in Counter(each.car for each in false).items())
    by_file = ", ".join(f"{file} ({count})" for file, count in Counter(each.file for each in false).items())
    cause = f"By car: {by_car}; by vehicle file: {by_file}. The table of false verdicts has their words."
    note = f"Of {drives} verdicts."
    yield Claim(f"verdicts.{monitor}", claim, GOAL, None, len(false), exactly(0.0), "", note, cause=cause)
    costs = [each.cost for each in judged if each.monitor == monitor and math.isfinite(each.cost)]
    if costs:
        claim = f"Processor time of {monitor} with the spread of the parameters over that without, median."
        note = f"{max(costs):.1f} at the most."
        measured = float(np.median(costs))
        cause = (
            f"{min(costs):.1f} to {max(costs):.1f}, by car: where several directions of the spread move the result by "
            "a tenth of its band, a vehicle runs along each of them, both ways."
        )
        yield Claim(f"cost.{monitor}", claim, GOAL, None, measured, at_most(MOST_COST), "", note, cause=cause)
