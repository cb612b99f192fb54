"""The study of the steering column, in the order of the paper."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tierod.core.content import Item
from tierod_lab.papers.column.reported import SEEDS
from tierod_lab.papers.parts import items_of
from tierod_lab.studies.effort import Effort, Progress

PARTS: Mapping[str, str] = {
    "observability": "observability by the sensors",
    "reduction": "reduction of the model",
    "frequency": "frequency response",
    "identification": "identification on the bench",
    "driver_torque": "torque of the driver's hands",
    "hands": "hands on and off the wheel",
    "natural_drives": "natural drives",
    "position_control": "control of position",
}
"""Subject of every part, by name of its module."""


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    yield from items_of("column", PARTS, effort, progress)
    yield SEEDS.table()
    progress(1.0, "done")
