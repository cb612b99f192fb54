"""The study of condition monitoring: its parts in the order of the paper."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tierod.core.content import Item
from tierod_lab.papers.parts import items_of
from tierod_lab.studies.effort import Effort, Progress

PARTS: Mapping[str, str] = {
    "driven": "what is driven",
    "figures": "the paper's figures",
    "trends": "residuals over time",
    "two_bodies": "the steering as two bodies",
    "residuals": "sensitivity of every residual",
    "sensors": "tests of the sensors",
    "actuators": "tests of the actuators",
    "substitutes": "substitutes of the sensors",
    "beyond": "more faults, and two at once",
    "uncalibrated": "uncalibrated vehicles",
    "closed_loop": "faults that the driver acts on",
    "theory": "isolability in theory and in the drives",
    "healthy": "fault-free driving",
    "odd": "odd recordings",
    "real_cars": "real cars",
}
"""Module of every part -> its title for the progress."""


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    yield from items_of("condition", PARTS, effort, progress)
    progress(1.0, "done")
