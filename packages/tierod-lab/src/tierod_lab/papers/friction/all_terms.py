"""The joint filter with all terms of eq (19), on cars with a variable and with a constant steering ratio."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tierod.core.claims import Claim, at_most
from tierod.core.content import Heading, Item, Table
from tierod_lab.papers.friction import estimators as named
from tierod_lab.papers.friction.cases import HEALTHY, STATES, Case
from tierod_lab.papers.friction.paper_sets import SOURCE, WORST
from tierod_lab.papers.friction.runs import Drives, Wants
from tierod_lab.papers.friction.setups import RATIO_GROWTH, VARIABLE_RATIO
from tierod_lab.papers.friction.statistics import mean, plus_minus, pooled
from tierod_lab.studies.effort import Effort

LEVELS = (HEALTHY, STATES[WORST])
ROADS = {"as usual": "constant ratio", VARIABLE_RATIO: f"ratio grows by {100 * RATIO_GROWTH:g} % per rad²"}
"""Condition in `CONDITIONS` -> its words in the table."""
TERMS = {
    named.OPEN: "ratio constant, sign frozen (as the paper)",
    named.RATIO: "rho(theta)",
    named.RATIO_SLOPE: "rho(theta) and rho'",
    named.ALL_TERMS: "rho(theta), rho' and delta (eq 19)",
}
"""Estimator in `ESTIMATORS` -> its words in the table."""
TEXT = (
    "Eq (19) has two terms more than the filter that the paper runs: with the slope of the ratio, and with Dirac's "
    "delta, which is twice as large as printed and here as wide as a sign smoothed over 0.02 rad/s. All filters have "
    "an open self-aligning torque (Q of it 1e4) and know the ratio's growth where they use it.",
)


def cases(condition: str, level: float, effort: Effort) -> tuple[Case, ...]:
    """Drives under a condition at a friction level [N*m]; the routes are the same for all."""
    routes, minutes = ((8101,), 4.0) if effort.quick else ((8101, 8102, 8103), 7.0)
    return tuple(Case(route, level, minutes, condition=condition) for route in routes)


def wants(effort: Effort) -> Wants:
    """The drives on both kinds of ratio."""
    return {case: tuple(TERMS) for condition in ROADS for level in LEVELS for case in cases(condition, level, effort)}


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    found = {
        (condition, level, name): pooled(drives.of(cases(condition, level, effort)), name)
        for condition in ROADS
        for level in LEVELS
        for name in TERMS
    }
    yield Heading("All terms of eq (19)", TEXT)
    rows = tuple(
        (words, *(plus_minus(found[condition, level, name]) for condition in ROADS for level in LEVELS))
        for name, words in TERMS.items()
    )
    header = ("terms", *(f"{road}, {level:g} N·m" for road in ROADS.values() for level in LEVELS))
    yield Table("Estimates by the terms of eq (19), mean ± standard deviation (N·m)", header, rows)
    yield from _claims(found)


def _claims(found: Mapping[tuple[str, float, str], np.ndarray]) -> Iterator[Claim]:
    usual, fast = "as usual", VARIABLE_RATIO

    def moved(condition: str, one: str, other: str) -> float:
        pairs = ((found[condition, level, one], found[condition, level, other]) for level in LEVELS)
        return max(abs(mean(first) - mean(second)) for first, second in pairs)

    yield Claim(
        "paper.delta-term",
        "The term of eq (19) with Dirac's delta can be left out, as the enabling conditions avoid standstill.",
        f"{SOURCE}, appendix B",
        "ignored",
        max(moved(condition, named.ALL_TERMS, named.RATIO_SLOPE) for condition in ROADS),
        at_most(0.2),
        "N*m",
        "Largest change of a mean estimate.",
    )
    yield Claim(
        "paper.ratio-slope-term",
        "The term of eq (19) with the slope of the ratio can be left out, as the ratio hardly varies.",
        f"{SOURCE}, appendix B",
        "ignored",
        moved(fast, named.RATIO_SLOPE, named.RATIO),
        at_most(0.2),
        "N*m",
        f"Largest change of a mean estimate on a ratio that grows by {100 * RATIO_GROWTH:g} % per rad².",
    )
    yield Claim(
        "paper.constant-ratio",
        "The ratio can be taken as constant.",
        f"{SOURCE}, appendix B",
        "constant",
        moved(fast, named.RATIO, named.OPEN),
        at_most(0.2),
        "N*m",
        "Largest change of a mean estimate on the same ratio; on a constant one "
        f"{moved(usual, named.RATIO, named.OPEN):.3f}.",
    )
