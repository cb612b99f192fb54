"""Seeds of the reported fleets; they change whenever the judged friction monitor changes."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.block import Block
from tierod.vehicles import load
from tierod_lab.papers.seeds import ReportedSeeds


def _judged() -> Sequence[Block]:
    from tierod.monitors.friction.definition import FrictionMonitor

    return (FrictionMonitor.of_vehicle(load("midsize-eps"), 0.01),)


YEARS, BATCHES, DRIVEN = "vehicle-years", "batches", "cars that are driven"

SEEDS = ReportedSeeds(_judged, {YEARS: 0, BATCHES: 10_000, DRIVEN: 20_000}, "the friction monitor of midsize-eps")
