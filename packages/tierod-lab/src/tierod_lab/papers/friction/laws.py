"""Friction laws outside the model of the default estimator: bias of the estimate, and the verdict."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.claims import Claim, between, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.statuses import Status
from tierod_lab.papers.friction import estimators as named
from tierod_lab.papers.friction.cases import HEALTHY, Case
from tierod_lab.papers.friction.fleet import FOUND, GOAL, LARGEST_BIAS
from tierod_lab.papers.friction.runs import Drives, Wants
from tierod_lab.papers.friction.setups import UNKNOWN_LAWS
from tierod_lab.papers.friction.statistics import mean, plus_minus, pooled
from tierod_lab.studies.effort import Effort

LEVELS = (4.0, 5.5, 8.0, 12.5)
COMPARED = (named.DEFAULT, named.SINGLE_LAW, named.CORRECTED, named.PRINTED)


def _reference(law: str, effort: Effort) -> Case:
    return Case(7000, HEALTHY, 5.0 if effort.quick else 7.0, law=law)


def cases(law: str, level: float, effort: Effort) -> tuple[Case, ...]:
    """Drives with a law at a friction level [N*m], with the baseline of a fault-free drive with the same law."""
    minutes, routes = (5.0, (7001,)) if effort.quick else (7.0, (7001, 7002))
    return tuple(Case(route, level, minutes, law=law, reference=_reference(law, effort)) for route in routes)


def _laws(effort: Effort) -> list[str]:
    return list(UNKNOWN_LAWS)[:1] if effort.quick else list(UNKNOWN_LAWS)


def wants(effort: Effort) -> Wants:
    """The drives under every law."""
    return {case: COMPARED for law in _laws(effort) for level in LEVELS for case in cases(law, level, effort)}


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Friction laws outside the estimator's model",
        (
            "The estimator models friction that builds up over an angle by three shapes. Real friction may follow "
            "another law; then the value may be biased, but a change from the car's baseline must still be detected.",
        ),
    )
    rows = []
    for law in _laws(effort):
        for name in COMPARED:
            cells = [plus_minus(pooled(drives.of(cases(law, level, effort)), name), level) for level in LEVELS]
            rows.append((law, name, *cells))
    header = ("law", "estimator", *(f"{level:g} N·m" for level in LEVELS))
    yield Table("Unknown friction laws: bias ± standard deviation (N·m)", header, tuple(rows))
    wrong, total, verdict_rows = 0, 0, []
    for law in _laws(effort):
        said = {level: _said(cases(law, level, effort), drives) for level in LEVELS}
        for level, statuses in said.items():
            total += len(cases(law, level, effort))
            right = [Status.HEALTHY] if level == HEALTHY else FOUND
            wrong += len(cases(law, level, effort)) - sum(status in right for status in statuses)
        verdict_rows.append((law, *(", ".join(dict.fromkeys(map(str, statuses))) for statuses in said.values())))
    header = ("law", *(f"{level:g} N·m" for level in LEVELS))
    yield Table("Unknown friction laws: verdict against the baseline", header, tuple(verdict_rows))
    yield Claim(
        "laws.verdicts",
        "Under every unknown friction law the verdict against the baseline is right.",
        GOAL,
        None,
        float(wrong),
        exactly(0.0),
        "",
        f"Wrong verdicts, of {total}: healthy at 4 N·m, rising or fault at 5.5, 8 and 12.5 N·m.",
    )
    for law in _laws(effort):
        errors = [mean(pooled(drives.of(cases(law, level, effort)), named.DEFAULT)) - level for level in LEVELS]
        yield Claim(
            f"laws.bias-{_slug(law)}",
            f"Bias of the default estimator: {law}.",
            GOAL,
            None,
            max(errors, key=abs),
            between(-LARGEST_BIAS, LARGEST_BIAS),
            "N*m",
            "Largest of four levels up to 12.5 N·m, with its sign.",
            cause=f"By level: {', '.join(f'{e:+.2f} at {level:g}' for e, level in zip(errors, LEVELS, strict=True))} "
            "N·m. The law is none of those that the estimator learns. A further law that is learnt would mend it, at "
            "the cost of scatter; the verdict by the ratio to the baseline is judged apart.",
        )


def _said(chosen: tuple[Case, ...], drives: Drives) -> list[Status]:
    return [each.verdict.status for each in drives.of(chosen) if each.verdict is not None]


def _slug(law: str) -> str:
    return "-".join("".join(c if c.isalnum() or c == "." else " " for c in law.lower()).split())
