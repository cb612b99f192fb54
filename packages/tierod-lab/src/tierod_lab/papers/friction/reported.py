"""The judged monitor, and the seeds of the reported drives, which change whenever it changes."""

from __future__ import annotations

from functools import cache

from tierod.monitors.friction.definition import FrictionMonitor
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.seeds import ReportedSeeds


@cache
def vehicle() -> Vehicle:
    """Vehicle file that every estimator of the study assumes, whatever car is driven."""
    return load("midsize-eps")


def monitor(level: tuple[float, float] | None = None) -> FrictionMonitor:
    """The default estimator with its verdict.

    Args:
        level: baseline of the car from an earlier drive and its standard deviation [N*m]; None learns it
    """
    return FrictionMonitor.of_vehicle(vehicle(), 0.01, *(level or (None, 0.0)))


DRIVES, TURNS = "cars and drives", "turns from lock to lock"

SEEDS = ReportedSeeds(lambda: (monitor(),), {DRIVES: 0, TURNS: 50_000}, f"the friction monitor of {vehicle().name}")
