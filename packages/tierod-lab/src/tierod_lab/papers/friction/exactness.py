"""Bias and scatter on the nominal car, by friction law and noise of the rate, and without parts of the estimator."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tierod.core.content import Heading, Item, Table
from tierod_lab.papers.friction import estimators as named
from tierod_lab.papers.friction.cases import Case
from tierod_lab.papers.friction.runs import Drives, Wants
from tierod_lab.papers.friction.statistics import plus_minus, pooled
from tierod_lab.studies.effort import Effort

LEVELS = (4.0, 8.0, 12.5)
ROUTES = (1001, 1002)

KINDS: Mapping[str, tuple[str, str]] = {
    "Coulomb": ("Coulomb", "as usual"),
    "Dahl 0.3°": ("Dahl 0.3°", "as usual"),
    "Dahl 1°": ("Dahl 1°", "as usual"),
    "Dahl 3°": ("Dahl 3°", "as usual"),
    "Dahl 1°, rate noise 0.05 rad/s": ("Dahl 1°", "rate noise 0.05 rad/s"),
    "Dahl 3°, rate noise 0.05 rad/s": ("Dahl 3°", "rate noise 0.05 rad/s"),
}
"""Kind of drive -> its friction law in `LAWS` and its condition in `CONDITIONS`."""

NOISY = (named.PRINTED_SMOOTH, named.CORRECTED_SMOOTH)
CHANGES = (named.ONE_LAW, named.NO_LOAD, named.NO_DROP, named.RIGID, named.NO_ROAD)
COMPARED = (
    named.DEFAULT,
    named.SINGLE_LAW,
    named.CORRECTED,
    named.UNSCENTED,
    named.PRINTED,
    named.PER_SAMPLE,
    named.OPEN,
)


def cases(effort: Effort, kind: str, level: float) -> tuple[Case, ...]:
    """Drives of a kind at a friction level [N*m]; all kinds share the routes, so that nothing else differs."""
    law, condition = KINDS[kind]
    minutes, routes = (4.0, ROUTES[:1]) if effort.quick else (8.0, ROUTES)
    return tuple(Case(route, level, minutes, law=law, condition=condition) for route in routes)


def _kinds(effort: Effort) -> list[str]:
    return list(KINDS)[2:3] if effort.quick else list(KINDS)


def wants(effort: Effort) -> Wants:
    """The drives of every kind and level."""
    return {
        case: (*COMPARED, *(NOISY if "noise" in kind else ()), *CHANGES)
        for kind in _kinds(effort)
        for level in LEVELS
        for case in cases(effort, kind, level)
    }


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    yield Heading(
        "How exact on the nominal car",
        (
            "The car that the estimators assume, on summer tyres, with sensors of a production car. Friction "
            "builds up over an angle after each reversal (Dahl), which the filters of the paper do not model: they "
            "take the sign of the rate and read low, the more the softer friction is.",
        ),
    )
    rows = []
    for kind in _kinds(effort):
        for name in (*COMPARED, *(NOISY if "noise" in kind else ())):
            cells = [plus_minus(pooled(drives.of(cases(effort, kind, level)), name), level) for level in LEVELS]
            rows.append((kind, name, *cells))
    header = ("friction", "estimator", *(f"{level:g} N·m" for level in LEVELS))
    yield Table("Nominal car: bias ± standard deviation after 50 s enabled (N·m)", header, tuple(rows))
    rows = []
    for kind in _kinds(effort):
        for name in (named.DEFAULT, *CHANGES, named.SINGLE_LAW):
            rows.append((kind, name, plus_minus(pooled(drives.of(cases(effort, kind, 12.5)), name), 12.5)))
    yield Table(
        "What parts of the default estimator bring on these drives: bias ± standard deviation (N·m)",
        ("friction", "estimator", "12.5 N·m"),
        tuple(rows),
        "Three laws and the load share act on friction that does not build up exponentially, see the unknown laws.",
    )
