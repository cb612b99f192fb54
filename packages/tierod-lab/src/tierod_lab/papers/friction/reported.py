"""Seeds of the reported friction drives, which change whenever the friction monitor changes."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.block import Block
from tierod_lab.papers.friction.estimators import monitor, vehicle
from tierod_lab.papers.seeds import ReportedSeeds


def _judged() -> Sequence[Block]:
    return (monitor(),)


DRIVES, TURNS = "cars and drives", "turns from lock to lock"

SEEDS = ReportedSeeds(_judged, {DRIVES: 0, TURNS: 50_000}, f"the friction monitor of {vehicle().name}")
