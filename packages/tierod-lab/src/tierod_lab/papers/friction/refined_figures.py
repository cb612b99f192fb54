"""The refined algorithm of the paper on its drives: Table 2 and Figures 5 to 9."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tierod.core.content import Bars, Boxes, Chart, Heading, Item, Lines, Panel, Points, Table
from tierod_lab.papers.friction import estimators as named
from tierod_lab.papers.friction.cases import STATES
from tierod_lab.papers.friction.digest import KEPT, RATE, READY_SECONDS, Digest
from tierod_lab.papers.friction.paper_sets import WORST, PaperSets, paper_sets, quantities
from tierod_lab.papers.friction.runs import Drives
from tierod_lab.papers.friction.setups import TYRES
from tierod_lab.papers.friction.statistics import deviation, edges, mean, plus_minus, pooled, shares
from tierod_lab.studies.effort import Effort

THRESHOLD = 7.5
"""Threshold half-way between the nominal friction, 4, and the least that a driver notices, 11 [N*m]; Table 1."""

INITIAL = 3.0  # Initial friction estimate of the paper's filter [N*m]

READINGS = (named.PRINTED, named.POSTERIOR, named.PER_SAMPLE, named.OPEN, named.CORRECTED, named.UNSCENTED)


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    sets = paper_sets(effort)
    estimates = {state: pooled(drives.of(sets.all_of(state)), named.PRINTED) for state in STATES}
    yield Heading(
        "The refined algorithm",
        (
            "The enabled Kalman filter as printed, with the obvious misprints corrected. It assumes the nominal "
            "car; the cars driven differ from it and from each other in tyres, trail, damping, inertia and in the "
            "gains and offsets of their sensors.",
        ),
    )
    yield quantities(sets, drives)
    yield from _courses(sets, drives)
    yield _distributions(estimates)
    yield _boxes(estimates)
    yield from _by_tyres(sets, drives)
    yield _readings(sets, drives)


def _courses(sets: PaperSets, drives: Drives) -> Iterator[Chart]:
    for number, state in ((5, "Healthy"), (6, WORST)):
        case = sets.development[state][0]
        for digest in drives.of([case]):
            yield _course_chart(number, state, digest)


def _course_chart(number: int, state: str, digest: Digest) -> Chart:
    course = digest.courses[named.PRINTED]
    time = np.arange(len(course.friction)) * (KEPT / RATE) / 60.0
    ready = course.enabled_seconds > READY_SECONDS
    begins = float(time[np.argmax(ready)]) if ready.any() else math.nan
    return Chart(
        f"figure-{number}",
        f"Figure {number}: friction estimated on a drive, {state}",
        "Above the steering profile, beneath the estimate of the printed filter and, for comparison, of tierod's "
        "default estimator. Dashed: the true friction. The paper leaves out the first 50 s of enabled time.",
        f"Estimate of the printed filter over a drive with {STATES[state]:g} N·m; it starts at 3 N·m.",
        (
            Panel(
                "steering profile",
                "time [min]",
                "angle [°]",
                (Lines("steering wheel angle", time, np.degrees(digest.angle)),),
            ),
            Panel(
                "estimated friction",
                "time [min]",
                "friction [N·m]",
                (
                    Lines("printed filter", time, course.friction),
                    Lines("default estimator", time, digest.courses[named.DEFAULT].friction),
                ),
                levels=(("true friction", STATES[state]),),
                uprights=(("50 s enabled", begins),) if math.isfinite(begins) else (),
            ),
        ),
    )


def _distributions(estimates: dict[str, np.ndarray]) -> Chart:
    at = edges(estimates["Healthy"], estimates[WORST])
    return Chart(
        "figure-7",
        "Figure 7: friction estimates, healthy against PWM 25%",
        "Share of the estimates of the printed filter, development and test sets together. Dashed: the threshold of "
        f"{THRESHOLD:g} N·m, half-way between nominal friction and the least that a driver notices.",
        "Histograms of the estimates of the healthy and the faulty car; ranges in the table beneath.",
        (
            Panel(
                "",
                "estimated friction [N·m]",
                "share of the estimates",
                tuple(Bars(state, at, shares(estimates[state], at)) for state in ("Healthy", WORST)),
                uprights=(("threshold", THRESHOLD),),
            ),
        ),
    )


def _boxes(estimates: dict[str, np.ndarray]) -> Chart:
    states = list(STATES)
    return Chart(
        "figure-8",
        "Figure 8: friction estimates of all data",
        "Boxes: one standard deviation about the mean of the printed filter's estimates; whiskers: two. Points: truth.",
        "Mean and spread of the estimates of every health state beside the true friction.",
        (
            Panel(
                "",
                "health state",
                "friction [N·m]",
                (
                    Boxes.normal(
                        "printed filter",
                        states,
                        [mean(estimates[state]) for state in states],
                        [deviation(estimates[state]) for state in states],
                    ),
                    Points("truth", states, [STATES[state] for state in states]),
                ),
            ),
        ),
    )


def _by_tyres(sets: PaperSets, drives: Drives) -> Iterator[Item]:
    found = {
        (tyres, state): pooled(drives.of(sets.on(tyres, state)), named.PRINTED) for tyres in TYRES for state in STATES
    }
    shown = [tyres for tyres in TYRES if len(found[tyres, "Healthy"]) and len(found[tyres, WORST])]
    at = edges(*(found[tyres, state] for tyres in shown for state in ("Healthy", WORST)))
    yield Chart(
        "figure-9",
        "Figure 9: friction estimates by tyres",
        "As Figure 7, one field per kind of tyre.",
        "Histograms of the estimates of the healthy and the faulty car for every kind of tyre.",
        tuple(
            Panel(
                tyres,
                "estimated friction [N·m]" if tyres == shown[-1] else "",
                "share",
                tuple(Bars(state, at, shares(found[tyres, state], at)) for state in ("Healthy", WORST)),
            )
            for tyres in shown
        ),
    )
    yield Table(
        "Figure 9 in figures: estimates of the printed filter by tyres (mean ± standard deviation, N·m)",
        ("tyres", "Healthy", WORST),
        tuple((tyres, *(plus_minus(found[tyres, state]) for state in ("Healthy", WORST))) for tyres in shown),
    )


def _readings(sets: PaperSets, drives: Drives) -> Table:
    rows = []
    for name in (*READINGS, named.DEFAULT):
        cells = [plus_minus(pooled(drives.of(sets.all_of(state)), name), STATES[state]) for state in STATES]
        rows.append((name, *cells))
    return Table(
        "Figure 8 for every reading of the paper: bias ± standard deviation, development and test sets (N·m)",
        ("estimator", *(f"{state}, {STATES[state]:g} N·m" for state in STATES)),
        tuple(rows),
    )
