"""The study of foreign plants: motion sensors of a car, friction of a column, and motors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tierod.core.content import Item
from tierod_lab.papers.foreign.reported import FRICTION, MOTORS, SENSORS
from tierod_lab.papers.parts import items_of
from tierod_lab.studies.effort import Effort, Progress

PARTS: Mapping[str, str] = {
    "cars": "sensors of a foreign car",
    "friction": "friction on a foreign column",
    "motors": "motors of motulator",
}
"""Subject of every part, by name of its module."""


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    yield from items_of("foreign", PARTS, effort, progress)
    for seeds in (SENSORS, FRICTION, MOTORS):
        yield seeds.table()
    progress(1.0, "done")
