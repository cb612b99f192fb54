"""The study of own cars: virtual cars drawn over the classes, motors with a data sheet, then real cars."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.content import Item
from tierod_lab.papers.own_car import motors, real, virtual
from tierod_lab.papers.own_car.reported import SEEDS
from tierod_lab.studies.effort import Effort, Progress


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    progress(0.0, "virtual cars that are not known")
    yield from virtual.items(effort, lambda share, what: progress(0.8 * share, what))
    progress(0.8, "motors that are not known")
    yield from motors.items(effort)
    progress(0.9, "real cars")
    yield from real.items()
    yield SEEDS.table()
    progress(1.0, "done")
