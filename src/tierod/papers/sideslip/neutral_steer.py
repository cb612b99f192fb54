"""Neutral steer: sideslip is unobservable from the yaw rate alone, and observable with the aligning torque."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.claims import Claim, exactly
from tierod.core.content import Heading, Item
from tierod.experiments.effort import Effort
from tierod.methods.analysis.neutral_steer import Shown, shown, table
from tierod.papers.sideslip.matching import from_file
from tierod.papers.sideslip.table import PAPER

RATIOS = (0.8, 0.95, 0.99, 1.0, 1.01, 1.05, 1.4)
SPEEDS = (6.7, 25.0, 40.0)
"""Speeds [m/s]."""


def items(effort: Effort) -> Iterator[Item]:
    """Table of observability over understeer and speed, and the claims."""
    speeds = SPEEDS[:2] if effort.quick else SPEEDS
    found = shown(from_file(), RATIOS, speeds)
    yield Heading(
        "Neutral steer",
        (
            "Rank of observability, from the orthonormal staircase, for the car of the vehicle file whose rear "
            "axle is made softer and stiffer. Rear over neutral is its cornering stiffness over that with which the "
            "car neither understeers nor oversteers. The margin is the share of the sideslip in the yaw rate, "
            "for states of usual magnitude (0.02 rad, 0.2 rad/s). A rank counts any non-zero direction; the margin "
            "indicates that near neutral steer a stiffness error of one percent is as large as the observable part.",
        ),
    )
    yield table(found)
    neutral = [each for each in found if each.rear_over_neutral == 1.0]
    yield from _claims(neutral, found)


def _claims(neutral: list[Shown], all_of_them: list[Shown]) -> Iterator[Claim]:
    yield Claim(
        "paper.neutral-yaw-rate",
        "In neutral steer the sideslip is not observable by the yaw rate alone.",
        f"{PAPER}, section V",
        "unobservable",
        float(max(each.by_outputs[0].rank for each in neutral)),
        exactly(1.0),
        "",
        "Largest rank over the speeds; two states.",
    )
    yield Claim(
        "paper.neutral-aligning-torque",
        "With the aligning torque as a second measurement the vehicle is always observable.",
        f"{PAPER}, section VI",
        "always",
        float(min(each.by_outputs[1].rank for each in all_of_them)),
        exactly(2.0),
        "",
        "Smallest rank over understeer and speed; two states.",
    )
    yield Claim(
        "paper.neutral-steering-model",
        "With the steering in the model, yaw rate and steering angle show all four states in neutral steer.",
        f"{PAPER}, section V",
        "observable",
        float(min(each.by_outputs[2].rank for each in all_of_them)),
        exactly(4.0),
        "",
        "Smallest rank over understeer and speed. The angle alone shows them as well.",
    )
