"""Convergence time of the printed filter to the true friction, for several values of P0, which is not printed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from tierod.core.claims import Claim, between
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod_lab.papers.friction import estimators as named
from tierod_lab.papers.friction.cases import STATES, Case
from tierod_lab.papers.friction.digest import KEPT, RATE, Digest
from tierod_lab.papers.friction.paper_sets import SOURCE, WORST
from tierod_lab.papers.friction.refined_figures import INITIAL
from tierod_lab.papers.friction.runs import Drives, Wants
from tierod_lab.papers.friction.statistics import mean
from tierod_lab.studies.effort import Effort

TRUE = STATES[WORST]
SHARES = (0.5, 0.8, 0.9)  # Shares of the way from the initial estimate to the true friction [-]
PRINTED_SECONDS = {"enabled": 50.0, "total": 150.0}
GOALS = {"enabled": between(30.0, 75.0), "total": between(90.0, 225.0)}
TEXT = (
    "The paper's filter starts at 3 N·m and needs some 50 s of enabled time, 150 s in all, to converge; P0 of friction "
    "is not printed. Here times run from the start until the estimate has gone a share of the way to the true "
    "12.5 N·m, not to its own mean. Friction that builds up over an angle leaves every such filter short of it.",
)


def cases(effort: Effort) -> tuple[Case, ...]:
    """Drives with the largest friction level of the paper."""
    routes, minutes = ((8201,), 4.0) if effort.quick else ((8201, 8202, 8203, 8204, 8205), 10.0)
    return tuple(Case(route, TRUE, minutes) for route in routes)


def wants(effort: Effort) -> Wants:
    """The drives, and the printed filter with every P0."""
    return dict.fromkeys(cases(effort), tuple(named.OF_VARIANCE.values()))


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    digests = drives.of(cases(effort))
    yield Heading("Convergence to the true friction over P0", TEXT)
    rows = []
    for variance, name in named.OF_VARIANCE.items():
        times = [_mean_time(digests, name, share) for share in SHARES]
        after = (f"{_mean_after(digests, name, seconds):.1f}" for seconds in (50.0, 150.0))
        cells = (f"{enabled:.0f} / {total:.0f}" if math.isfinite(enabled) else "never" for enabled, total in times)
        own = _own(digests, name)
        rows.append((f"{variance:g}", *cells, *after, f"{own:.0f}" if math.isfinite(own) else "never"))
    header = ("P0 [(N·m)²]", *(f"{100 * share:.0f} % of the way, enabled / total [s]" for share in SHARES))
    yield Table(
        "Time of the printed filter to the true friction, from 3 to 12.5 N·m, means of the drives",
        (*header, "N·m after 50 s enabled", "after 150 s enabled", "95 % of the way to its own mean, enabled [s]"),
        tuple(rows),
        "Never: in some drive it does not come so far.",
    )
    if digests:
        yield _courses(digests[0])
    yield from _claims(digests)


def reached(digest: Digest, name: str, share: float, true: float = TRUE) -> tuple[float, float]:
    """Enabled and total time [s] until an estimate has gone a share of the way to the truth; infinite if it never does.

    Args:
        share: share of the way from the initial estimate of 3 N*m [-]
        true: friction level at the end of the way [N*m]
    """
    course = digest.courses[name]
    short = course.friction < INITIAL + share * (true - INITIAL)
    if short.all():
        return math.inf, math.inf
    place = int(np.argmin(short))
    return float(course.enabled_seconds[place]), place * KEPT / RATE


def _mean_time(digests: Sequence[Digest], name: str, share: float) -> tuple[float, float]:
    times = [reached(each, name, share) for each in digests]
    return mean(np.array([time[0] for time in times])), mean(np.array([time[1] for time in times]))


def _own(digests: Sequence[Digest], name: str) -> float:
    """Enabled time [s] to 95 % of the way to the mean of the filter's own settled estimates, which may be biased."""
    times = [reached(each, name, 0.95, each.mean(name))[0] for each in digests if math.isfinite(each.mean(name))]
    return mean(np.array(times)) if times else math.inf


def _after(digest: Digest, name: str, seconds: float) -> float:
    """Estimate after an enabled time [s] in a drive [N*m]; NaN where the enabled time of the drive is shorter."""
    course = digest.courses[name]
    later = np.flatnonzero(course.enabled_seconds >= seconds)
    return float(course.friction[later[0]]) if len(later) else math.nan


def _mean_after(digests: Sequence[Digest], name: str, seconds: float) -> float:
    return mean(np.array([_after(each, name, seconds) for each in digests]))


def _courses(digest: Digest) -> Chart:
    time = np.arange(len(digest.angle)) * KEPT / RATE
    marks = tuple(
        Lines(f"P0 {variance:g}", time[::5], digest.courses[name].friction[::5])
        for variance, name in named.OF_VARIANCE.items()
    )
    panel = Panel("printed filter", "time [s]", "friction [N·m]", marks, levels=(("true", TRUE),))
    return Chart(
        "convergence-over-p0",
        "Course of the printed filter from 3 N·m over P0",
        "First drive; P0 is the variance of friction at the start. Dashed: the true level.",
        "Curves that rise from 3 towards 12.5 N·m, the sooner the larger P0 is.",
        (panel,),
    )


def _claims(digests: Sequence[Digest]) -> Iterator[Claim]:
    owns = ", ".join(f"{variance:g}: {_own(digests, name):.0f} s" for variance, name in named.OF_VARIANCE.items())
    for index, (kind, printed) in enumerate(PRINTED_SECONDS.items()):
        times = {variance: _mean_time(digests, name, 0.8)[index] for variance, name in named.OF_VARIANCE.items()}
        finite = {variance: time for variance, time in times.items() if math.isfinite(time)}
        # The floor keeps the logarithm finite where the estimate starts beyond the goal.
        off = {variance: abs(math.log(max(time, 0.1) / printed)) for variance, time in finite.items()}
        nearest = min(off, key=off.__getitem__, default=math.nan)
        words = ", ".join(
            f"{variance:g}: {time:.0f} s" if math.isfinite(time) else f"{variance:g}: never"
            for variance, time in times.items()
        )
        yield Claim(
            f"paper.convergence-{kind}",
            f"From its start at 3 N·m the filter needs about {printed:g} s ({kind}) to converge: 80 % of the way to "
            "the true 12.5 N·m, with the P0 that comes nearest.",
            f"{SOURCE}, section 5",
            printed,
            finite.get(nearest, math.nan),
            GOALS[kind],
            "s",
            "P0 is not printed.",
            cause=f"P0 is not printed, and it decides. To 80 % of the way to the truth, {kind}, by P0: {words}; "
            "friction that builds up over an angle leaves the filter short. To 95 % of the way to its own mean, "
            f"enabled: {owns}.",
            irreproducible=True,
        )
