"""The study of friction: runs all drives first, then yields one part after the other."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.claims import Claim, exactly
from tierod.core.content import Heading, Item
from tierod_lab.papers.friction import (
    all_terms,
    baseline,
    choices,
    conditions,
    convergence,
    exactness,
    fleet,
    hysteresis,
    laws,
    paper_sets,
    picture,
    refined_claims,
    refined_figures,
    steps,
    verdicts,
)
from tierod_lab.papers.friction.fleet import GOAL
from tierod_lab.papers.friction.reported import DRIVES, SEEDS
from tierod_lab.papers.friction.runs import Drives, run_drives
from tierod_lab.studies.effort import Effort, Progress

WANTS = (
    paper_sets.wants,
    convergence.wants,
    all_terms.wants,
    conditions.wants,
    picture.wants,
    fleet.wants,
    exactness.wants,
    laws.wants,
    steps.wants,
)
PARTS = (
    baseline.items,
    refined_figures.items,
    refined_claims.items,
    convergence.items,
    all_terms.items,
    choices.items,
    conditions.items,
    picture.items,
    fleet.items,
    verdicts.items,
    exactness.items,
    laws.items,
    steps.items,
)
_DRIVING = 0.9  # Share of the drives in the progress of the study [-]


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    def driving(share: float, what: str) -> None:
        progress(_DRIVING * share, what)

    drives = run_drives([wanted(effort) for wanted in WANTS], effort, driving, SEEDS.of(DRIVES, 1)[0])
    for part in PARTS:
        yield from part(drives, effort)
    progress(_DRIVING, "lock-to-lock turns")
    yield from hysteresis.items(hysteresis.turns(effort))
    yield from _ended(drives)
    yield SEEDS.table()
    progress(1.0, "done")


def _ended(drives: Drives) -> Iterator[Item]:
    if drives.failures:
        text = [f"{case}: {reason}" for case, reason in drives.failures]
        yield Heading("Drives that did not end well", tuple(text))
    yield Claim(
        "plant.drives-ended",
        "Every virtual drive of the study runs to its end.",
        GOAL,
        None,
        float(len(drives.failures)),
        exactly(0.0),
        "",
        f"Drives that did not, of {len(drives.failures) + len(drives.digests)}, {drives.hours:.1f} h in all.",
    )
