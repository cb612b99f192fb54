"""Claims of the paper about the choices in its filter, in section 4.3 and appendix B."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Item
from tierod.experiments.effort import Effort
from tierod.papers.friction import estimators as named
from tierod.papers.friction.cases import STATES, Case
from tierod.papers.friction.paper_sets import SOURCE, PaperSets, paper_sets
from tierod.papers.friction.refined_figures import READINGS
from tierod.papers.friction.runs import Drives
from tierod.papers.friction.statistics import deviation, joined, mean, pooled


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    """The claims."""
    sets = paper_sets(effort)
    yield from _on_filter(sets, drives)
    yield from _on_virtual_noise(sets, drives)


def _on_filter(sets: PaperSets, drives: Drives) -> Iterator[Claim]:
    cases = [case for state in STATES for case in sets.all_of(state)]
    error = {name: _mean_error(drives, cases, name) for name in READINGS}
    spread = {
        name: mean(np.array([deviation(pooled(drives.of(sets.all_of(s)), name)) for s in STATES])) for name in READINGS
    }
    yield Claim(
        "paper.operating-point-comparable",
        "Both operating points, the measured one and the a posteriori one, lead to comparable results.",
        f"{SOURCE}, appendix B",
        "comparable",
        abs(error[named.POSTERIOR] - error[named.PRINTED]),
        at_most(0.1),
        "N*m",
        "Difference of the mean absolute errors.",
    )
    yield Claim(
        "paper.operating-point-error",
        "With the a posteriori operating point the mean absolute error is larger than with the measured one.",
        f"{SOURCE}, appendix B",
        "larger",
        error[named.POSTERIOR] - error[named.PRINTED],
        at_least(0.005),
        "N*m",
        "Difference of the mean absolute errors.",
    )
    yield Claim(
        "paper.operating-point-spread",
        "With the a posteriori operating point the distributions are tighter.",
        f"{SOURCE}, appendix B",
        "tighter",
        spread[named.POSTERIOR] - spread[named.PRINTED],
        at_most(-0.005),
        "N*m",
        "Difference of the standard deviations, mean of the health states.",
    )
    yield Claim(
        "paper.unscented",
        "Without linearisation (unscented filter) accuracy and separability become optimal.",
        f"{SOURCE}, appendix B and section 6",
        "better",
        error[named.UNSCENTED] - error[named.CORRECTED],
        at_most(-0.005),
        "N*m",
        "Difference of the mean absolute errors of unscented and corrected Kalman filter.",
    )


def _on_virtual_noise(sets: PaperSets, drives: Drives) -> Iterator[Claim]:
    for name, words, reading in (
        (named.PRINTED, "as-printed", "Q as printed"),
        (named.PER_SAMPLE, "rows-of-one", "virtual rows of G read as one"),
        (named.OPEN, "open", "Q of it 1e4"),
    ):
        yield Claim(
            f"paper.aligning-torque-{words}",
            f"A large virtual noise makes the filter learn the course of the self-aligning torque ({reading}).",
            f"{SOURCE}, section 4.3",
            "learnt",
            mean(np.array([each.courses[name].aligning_error for each in drives.of(sets.all_of("Healthy"))])),
            at_most(0.5),
            "",
            "Root mean square error over the spread of the true torque; 1 is no better than a constant.",
        )


def _mean_error(drives: Drives, cases: list[Case], name: str) -> float:
    return mean(
        joined(np.abs(drives.digests[case].settled(name) - case.level) for case in cases if case in drives.digests)
    )
