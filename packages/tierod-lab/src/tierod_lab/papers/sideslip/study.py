"""The study of sideslip: its parts in order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tierod.core.content import Item
from tierod_lab.papers.parts import items_of
from tierod_lab.papers.sideslip.reported import SEEDS
from tierod_lab.studies.effort import Effort, Progress

PARTS: Mapping[str, str] = {
    "paper": "the paper's test",
    "table": "the observers side by side",
    "cosine": "the cosine of the steer",
    "limits": "limits at low speed",
    "bandwidth": "noise against bandwidth",
    "neutral_steer": "neutral steer",
    "combined": "the combined estimator",
    "real_cars": "two real cars",
    "unprepared": "cars without preparation",
    "slow_cars": "small and slow",
    "race_blocks": "race laps, block by block",
}
"""Subject of every part, by name of its module."""


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    yield from items_of("sideslip", PARTS, effort, progress)
    yield SEEDS.table()
    progress(1.0, "done")
