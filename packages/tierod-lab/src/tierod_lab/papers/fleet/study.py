"""The study of fleets: the measured errors of the monitor, then vehicle-years and batches drawn from them."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.content import Heading, Item
from tierod_lab.papers.fleet import batches, measured_errors, virtual_years
from tierod_lab.papers.fleet.reported import BATCHES, SEEDS, YEARS
from tierod_lab.studies.effort import Effort, Progress


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    progress(0.0, "drives of virtual cars")
    law = measured_errors.measured(effort)
    yield Heading(
        "Errors of the monitor",
        ("All fleets below are at estimate level: their drives are not driven, but drawn from these errors.",),
    )
    yield measured_errors.table(law)
    progress(0.5, "vehicle-years")
    yield Heading("False alarms and delays")
    yield from virtual_years.items(law, effort, SEEDS.of(YEARS, 1)[0])
    progress(0.9, "batches")
    yield Heading("Batches")
    yield from batches.items(law, effort, SEEDS.of(BATCHES, 1)[0])
    yield SEEDS.table()
    progress(1.0, "done")
