"""The conditions that reproduce the paper's figures, driven in every health state."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim, at_least, at_most, between
from tierod.core.content import Bars, Boxes, Chart, Heading, Item, Panel, Points
from tierod_lab.campaign.figures import area_under_curve
from tierod_lab.papers.friction import estimators as named
from tierod_lab.papers.friction.cases import STATES, Case
from tierod_lab.papers.friction.conditions import FAILING, PRINTED_DEVIATION
from tierod_lab.papers.friction.paper_sets import SOURCE, WORST
from tierod_lab.papers.friction.refined_claims import slug
from tierod_lab.papers.friction.runs import Drives, Wants
from tierod_lab.papers.friction.statistics import (
    BINS,
    best_accuracy,
    deviation,
    edges,
    joined,
    mean,
    overlap,
    pooled,
    shares,
)
from tierod_lab.studies.effort import Effort

CONDITION = "angle below the bar, driven fast"
FILTER, BASELINE = named.PNEUMATIC, named.BASELINE_SIGN


def cases(state: str, effort: Effort) -> tuple[Case, ...]:
    """Drives in a health state under the conditions found."""
    routes, minutes = ((8101,), 4.0) if effort.quick else ((8101, 8102, 8103, 8104), 7.0)
    return tuple(Case(route, STATES[state], minutes, condition=CONDITION) for route in routes)


def wants(effort: Effort) -> Wants:
    """The drives in every health state."""
    return {case: (FILTER, BASELINE) for state in STATES for case in cases(state, effort)}


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    groups = {state: drives.of(cases(state, effort)) for state in STATES}
    estimates = {state: pooled(groups[state], FILTER) for state in STATES}
    variances = {
        state: joined(digest.windows[BASELINE].variance for digest in groups[state]) for state in ("Healthy", WORST)
    }
    yield Heading(
        "The paper's picture",
        (
            "The conditions of the search, driven in every health state on routes of its own: the angle of the "
            "steering wheel measured at the motor, below the torsion bar; bends driven up to 5 m/s²; the virtual rows "
            "of G one; the pneumatic trail alone for l_p; eq (1) with its printed sign. The error of a trail that is "
            "half of the true one does not grow with friction. This is why all health states "
            "scatter alike, as in the paper.",
        ),
    )
    yield _chart(estimates, variances)
    yield from _claims(estimates, variances)


def _chart(estimates: dict[str, np.ndarray], variances: dict[str, np.ndarray]) -> Chart:
    ends = edges(estimates["Healthy"], estimates[WORST])
    # The largest variances would squeeze all others into a few bars.
    widest = max((float(np.quantile(values, 0.99)) for values in variances.values() if len(values)), default=1.0)
    steps = np.linspace(0.0, widest, BINS + 1)
    states = list(STATES)
    boxes = Boxes.normal(
        "estimate",
        states,
        [mean(estimates[state]) for state in states],
        [deviation(estimates[state]) for state in states],
    )
    return Chart(
        "picture",
        "Figures 3, 7 and 8 under the conditions found",
        "As above. Boxes: one standard deviation about the mean, whiskers: two.",
        "Overlapping variances of the baseline, and estimates of the filter that scatter alike in every health state.",
        (
            Panel(
                "Figure 3: rolling error variances",
                "variance [(N·m)²]",
                "share of the windows",
                tuple(Bars(state, steps, shares(values, steps)) for state, values in variances.items()),
            ),
            Panel(
                "Figure 7: friction estimates",
                "estimated friction [N·m]",
                "share of the estimates",
                tuple(Bars(state, ends, shares(estimates[state], ends)) for state in ("Healthy", WORST)),
            ),
            Panel(
                "Figure 8: friction estimates of every health state",
                "",
                "friction [N·m]",
                (boxes, Points("truth", states, list(STATES.values()))),
            ),
        ),
    )


def _claims(estimates: dict[str, np.ndarray], variances: dict[str, np.ndarray]) -> Iterator[Claim]:
    under = "Under the conditions found"
    low, high = PRINTED_DEVIATION
    for state, values in estimates.items():
        yield Claim(
            f"paper.picture-deviation-{slug(state)}",
            f"{under} every health state has a standard deviation of 1.5 to 2.2 N·m: {state}.",
            f"{SOURCE}, section 5 and Figure 8",
            "1.5 to 2.2",
            deviation(values),
            between(low, high),
            "N*m",
        )
    yield Claim(
        "paper.picture-under-estimation",
        f"{under} the true friction is under-estimated.",
        f"{SOURCE}, section 5",
        "under-estimated",
        max(mean(values) - STATES[state] for state, values in estimates.items()),
        at_most(-0.1),
        "N*m",
        "Bias of the health state with the highest one.",
    )
    yield Claim(
        "paper.picture-accuracy",
        f"{under} nominal and faulty steering are separated well.",
        f"{SOURCE}, section 5",
        "excellent",
        best_accuracy(estimates["Healthy"], estimates[WORST]),
        at_least(0.95),
        "",
        "Share of the estimates on their side of the best threshold, healthy against PWM 25%.",
    )
    yield Claim(
        "paper.picture-baseline",
        f"{under} the baseline's variances of healthy and faulty steering overlap.",
        f"{SOURCE}, section 4.2 and Figure 3",
        "overlap",
        overlap(*variances.values(), logarithmic=True),
        at_least(FAILING),
        "",
        f"Share that the histograms have in common; AUC {area_under_curve(*variances.values()):.2f}.",
    )
