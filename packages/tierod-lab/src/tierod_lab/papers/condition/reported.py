"""Demonstrators and seeds of the reported drives, which change whenever the condition monitor changes."""

from __future__ import annotations

from functools import cache

from tierod.monitors.condition.definition import condition_monitor
from tierod.vehicles import load
from tierod_lab.campaign.code import reported_seed
from tierod_lab.studies.effort import Effort

COUNT = 3  # Number of demonstrators in the tests

USED = 100  # Demonstrators up to this number were used while thresholds were chosen, and are not reported


@cache
def first_vehicle() -> int:
    """Number of the first demonstrator, which determines its parameters and the seeds of its drives."""
    return USED + 1 + 10 * (reported_seed(condition_monitor(load("smartload"))) % 100_000)


def vehicles(effort: Effort) -> tuple[int, ...]:
    """Numbers of the demonstrators of a study; a single one if it is quick."""
    return tuple(range(first_vehicle(), first_vehicle() + (1 if effort.quick else COUNT)))
