"""The study of foreign plants: motion sensors of a car, friction of a column, and motors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module

from tierod.core.content import Item
from tierod.experiments.effort import Effort, Progress
from tierod.papers.foreign.reported import FRICTION, MOTORS, SENSORS

PARTS: Mapping[str, str] = {
    "cars": "sensors of a foreign car",
    "friction": "friction on a foreign column",
    "motors": "motors of motulator",
}
"""Subject of every part, by name of its module."""


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    """All items of the study."""
    for done, (name, title) in enumerate(PARTS.items()):
        progress(done / len(PARTS), title)
        part: Callable[[Effort], Iterator[Item]] = import_module(f"tierod.papers.foreign.{name}").items
        yield from part(effort)
    for seeds in (SENSORS, FRICTION, MOTORS):
        yield seeds.table()
    progress(1.0, "done")
