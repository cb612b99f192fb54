"""Detection of a batch of 20 cars in 1 000 whose friction is up to 1 N m higher, after four weeks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Item, Table
from tierod.fleet.trends import Design, trends
from tierod_lab.fleet.estimates import ErrorLaw, estimates, series
from tierod_lab.fleet.virtual import FleetFile, Group, drawn
from tierod_lab.studies.effort import Effort

FLEETS, QUICK_FLEETS = 50, 3  # Number of fleets for each size of the difference, in full and in the quick study
CARS, SHARE, WEEKS = 1000, 0.02, 4  # Cars of a fleet, share of them in a batch, and weeks of drives
ODD = "2025-47"  # Name of the batch that differs
GOAL = "goal of tierod"
OTHERS = tuple(Group("rack batch", f"2025-{week:02d}", SHARE) for week in range(1, 47))
"""The batches that do not differ, 20 cars each."""


@dataclass(frozen=True)
class Fleet:
    """A virtual fleet with one batch that may differ."""

    friction: float  # excess friction of the batch `ODD` [N*m]
    law: ErrorLaw  # errors of the friction monitor
    seed: int  # seed of all random numbers


def judged(task: Fleet) -> tuple[bool, float, int, float]:
    """Whether the batch `ODD` ranks first with odds above 1, its log odds, other cohorts with odds above 1, its effect.

    The log odds are natural [nat], the effect is the estimated excess friction [N*m].
    """
    suppliers = (Group("supplier", "A", 0.5), Group("climate", "north", 0.3, warmer=-6.0))
    odd = Group("rack batch", ODD, SHARE, task.friction)
    file = FleetFile("batch", CARS, "2026-01-05", seed=task.seed, weeks=WEEKS, groups=(odd, *OTHERS, *suppliers))
    cars = drawn(file)
    found = trends(series(cars, *estimates(cars, task.law, (task.seed, 9))), Design()).cohorts.cohorts
    assert found is not None
    own = next(each for each in found.all if each.name == ODD)
    others = sum(each.log_odds > 0.0 for each in found.all if each.name != ODD)
    return found.all[0].name == ODD and own.log_odds > 0.0, own.log_odds, others, own.effect


def items(law: ErrorLaw, effort: Effort, seed: int) -> Iterator[Item]:
    count = QUICK_FLEETS if effort.quick else FLEETS
    sizes = (1.0, 0.5, 0.25, 0.0)
    tasks = [Fleet(size, law, seed + number) for size in sizes for number in range(count)]
    found = effort.made(judged, tasks)
    parts = [found[at * count : (at + 1) * count] for at in range(len(sizes))]
    rows = tuple(
        (
            f"{size:g}",
            str(count),
            f"{np.mean([each[0] for each in part]):.2f}",
            f"10^{np.median([each[1] for each in part]) / math.log(10.0):.1f}",
            f"10^{min(each[1] for each in part) / math.log(10.0):.1f}",
            f"{np.mean([each[3] for each in part]):+.2f}",
            f"{np.mean([each[2] for each in part]):.2f}",
        )
        for size, part in zip(sizes, parts, strict=True)
    )
    yield Table(
        "A batch of 20 cars in 1 000 after four weekly drives, estimate level",
        ("higher by [N·m]", "fleets", "named first", "odds, median", "odds, least", "effect [N·m]", "others named"),
        rows,
        f"{len(OTHERS) + 6} cohorts of three kinds in each fleet; prior odds 1 to 99.",
    )
    whole = parts[0]
    yield Claim(
        "batches.named", "A batch of 20 in 1 000 whose friction is 1 N·m higher is named after four weeks.", GOAL, None,
        float(np.mean([each[0] for each in whole])), at_least(0.98), "", f"Of {count} fleets.",
    )  # fmt: skip
    yield Claim(
        "batches.others", "Cohorts that do not differ are seldom named beside it.", GOAL, None,
        float(np.mean([each[2] for each in whole])), at_most(0.5), "", "Mean number in a fleet.",
    )  # fmt: skip
