"""The study of sideslip: its parts in order."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from tierod.core.content import Item
from tierod.experiments.effort import Effort, Progress
from tierod.papers.sideslip import (
    bandwidth,
    combined,
    cosine,
    limits,
    neutral_steer,
    paper,
    race_blocks,
    real_cars,
    slow_cars,
    table,
    unprepared,
)
from tierod.papers.sideslip.reported import SEEDS

Part = Callable[[Effort], Iterator[Item]]

PARTS: tuple[tuple[str, Part], ...] = (
    ("the paper's test", paper.items),
    ("the observers side by side", table.items),
    ("the cosine of the steer", cosine.items),
    ("limits at low speed", limits.items),
    ("noise against bandwidth", bandwidth.items),
    ("neutral steer", neutral_steer.items),
    ("the combined estimator", combined.items),
    ("two real cars", real_cars.items),
    ("cars without preparation", unprepared.items),
    ("small and slow", slow_cars.items),
    ("race laps, block by block", race_blocks.items),
)
"""Name for the progress, and function, of every part in order."""


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    """Headings, tables, charts and claims of all parts."""
    for done, (name, part) in enumerate(PARTS):
        progress(done / len(PARTS), name)
        yield from part(effort)
    yield SEEDS.table()
    progress(1.0, "done")
