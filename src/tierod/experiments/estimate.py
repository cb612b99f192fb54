"""Estimated time that a campaign will take, and data that it will keep, before it is run."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Annotated

from tierod.experiments.campaign import Campaign
from tierod.experiments.plan import Cell
from tierod.experiments.store import Store
from tierod.proving_ground.recorder import TRUTH_RATE, channel_names

TASTE = 10.0
"""Seconds of the first drive that are driven to find out how fast that goes."""

KEPT, JUDGED = 1.5, 1.1
"""Time for a drive with its verdicts, with and without its recording kept, over that for the drive alone; measured on
drives of 13 minutes of a mid-size car."""

START = 3.0
"""Seconds until the workers have read everything in."""


@dataclass(frozen=True)
class Estimate:
    """Estimated cost of a run of the campaign.

    Args:
        cells: of the matrix
        missing: of these, not finished yet
        hours: to be driven
        seconds: that it will take
        bytes: that it will keep
    """

    cells: int
    missing: int
    hours: Annotated[float, "h"]
    seconds: Annotated[float, "s"]
    bytes: int


def estimate(campaign: Campaign, store: Store, processes: int) -> Estimate:
    """Drive the first seconds of what is missing, and reckon.

    Args:
        campaign: that is to be run
        store: what is there already
        processes: how many will work at a time
    """
    plan = campaign.plan
    missing = [cell for cell in plan.cells if not plan.done(cell, store)]
    driven = sum(cell.scenario.duration for cell in missing)
    size = sum(_bytes_per_second(cell) * cell.scenario.duration for cell in missing) if plan.keep else 0.0
    beside = KEPT if plan.keep else JUDGED
    seconds = beside * driven / _speed(missing[0]) / max(processes, 1) + START if missing else 0.0
    return Estimate(len(plan.cells), len(missing), driven / 3600.0, seconds, round(size))


def _speed(cell: Cell) -> float:
    """Times real time; without faults, which would come after the end of so short a drive."""
    scenario = replace(cell.scenario, faults=()).with_run(seconds=min(TASTE, cell.scenario.duration))
    scenario.run()  # compiles what is not compiled
    began = time.perf_counter()
    scenario.run()
    return float(scenario.duration / (time.perf_counter() - began))


def _bytes_per_second(cell: Cell) -> float:
    """Bytes per second of a cell's recording; compression gains little on noise."""
    scenario = cell.scenario
    channels = channel_names(scenario.car)
    readings = sum(sensor.rate for name, sensor in scenario.sensors.items() if name in channels)
    return float(8.0 * (readings + TRUTH_RATE * len(channels)))
