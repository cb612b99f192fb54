"""Detection delay of the verdict after a step of friction, and time of the paper's filters to cross a threshold."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim, exactly
from tierod.core.content import Heading, Item, Table
from tierod_lab.ground import FrictionCourse
from tierod_lab.papers.friction import estimators as named
from tierod_lab.papers.friction.cases import HEALTHY, Case
from tierod_lab.papers.friction.digest import KEPT, RATE, Digest
from tierod_lab.papers.friction.fleet import GOAL
from tierod_lab.papers.friction.refined_figures import THRESHOLD
from tierod_lab.papers.friction.runs import Drives, Wants
from tierod_lab.studies.effort import Effort

STEPS = (12.5, 5.5)
COUNT = 6
COMPARED = (named.PRINTED, named.PER_SAMPLE, named.OPEN, named.CORRECTED, named.UNSCENTED)

KINDS = {
    "nominal": (False, "as usual"),
    "rate noise 0.05 rad/s": (False, "rate noise 0.05 rad/s"),
    "scatter": (True, "as usual"),
}
"""Kind of drive -> whether the car is drawn at random, and its condition in `CONDITIONS`."""


def cases(effort: Effort, after: float, kind: str) -> tuple[Case, ...]:
    """Drives whose friction steps up half-way to the level `after` [N*m]."""
    scattered, condition = KINDS[kind]
    minutes, count = (8.0, 1) if effort.quick else (12.0, COUNT)
    return tuple(
        Case(
            30_000 + number,
            FrictionCourse.step(HEALTHY, after, at=30.0 * minutes),
            minutes,
            car=3000 + number if scattered else None,
            condition=condition,
        )
        for number in range(count)
    )


def _kinds(effort: Effort) -> list[str]:
    return ["nominal"] if effort.quick else list(KINDS)


def wants(effort: Effort) -> Wants:
    """The drives with a step."""
    return {
        case: COMPARED if kind == "nominal" and after == STEPS[0] else ()
        for after in STEPS
        for kind in _kinds(effort)
        for case in cases(effort, after, kind)
    }


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    yield Heading("How soon", ("Friction steps up half-way through the drive; times are enabled time from the step.",))
    rows, early = [], 0
    for after in STEPS:
        for kind in _kinds(effort):
            verdicts = [d.verdict for d in drives.of(cases(effort, after, kind)) if d.verdict is not None]
            early += sum(verdict.early for verdict in verdicts)
            cells = []
            for which in (0, 1):
                times = sorted(verdict.delays[which] for verdict in verdicts)
                cells += [_time(float(np.median(times)) if times else math.nan), _time(max(times, default=math.nan))]
            rows.append((f"4 to {after:g} N·m, {kind}", *cells, str(sum(verdict.early for verdict in verdicts))))
    header = ("step", "rising, median", "rising, worst", "fault, median", "fault, worst", "alarms before")
    yield Table("Verdict after a step of friction (s enabled)", header, tuple(rows))
    rows = []
    for name in (*COMPARED, named.DEFAULT):
        crossings = [_crossing(digest, name) for digest in drives.of(cases(effort, STEPS[0], "nominal"))]
        rows.append((name, *(_range([crossing[i] for crossing in crossings]) for i in (0, 1))))
    yield Table(
        f"Step from 4 to 12.5 N·m: time to cross {THRESHOLD:g} N·m (s)", ("estimator", "enabled", "total"), tuple(rows)
    )
    yield Claim(
        "verdict.alarms-before-step",
        "No alarm comes before friction has changed.",
        GOAL,
        None,
        float(early),
        exactly(0.0),
        "",
        "Drives with an alarm before the step.",
    )


def _crossing(digest: Digest, name: str) -> tuple[float, float]:
    """Enabled and total time from the step until the estimate crosses the threshold [s]; infinite if it does not."""
    course = digest.courses[name]
    half = len(course.friction) // 2
    above = course.friction[half:] > THRESHOLD
    if not above.any():
        return math.inf, math.inf
    first = int(np.argmax(above))
    return float(course.enabled_seconds[half + first] - course.enabled_seconds[half]), first * KEPT / RATE


def _range(times: list[float]) -> str:
    return f"{_time(min(times))} to {_time(max(times))}" if times else "none"


def _time(value: float) -> str:
    return "" if math.isnan(value) else "never" if math.isinf(value) else f"{value:.1f}"
