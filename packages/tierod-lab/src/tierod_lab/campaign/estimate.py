"""Estimate of the time that a campaign takes and of the data that it keeps, before it is run."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Annotated

from tierod_lab.campaign.campaign import Campaign
from tierod_lab.campaign.plan import Cell
from tierod_lab.campaign.store import Store
from tierod_lab.ground.recorder import TRUTH_RATE, channel_names

TASTE = 10.0
"""Duration of the trial drive from which the simulation speed is measured [s]."""

KEPT, JUDGED = 1.5, 1.1
"""Time for a drive with its verdicts divided by that for the drive alone, with and without keeping its recording;
measured on drives of 13 minutes of a mid-size car."""

START = 3.0
"""Start-up time of the workers [s]."""


@dataclass(frozen=True)
class Estimate:
    """Estimated cost of a campaign.

    Args:
        cells: number of cells of the matrix
        missing: number of unfinished cells
        hours: driving time of the unfinished cells
        seconds: computing time
        bytes: size of the recordings
    """

    cells: int
    missing: int
    hours: Annotated[float, "h"]
    seconds: Annotated[float, "s"]
    bytes: int


def estimate(campaign: Campaign, store: Store, processes: int) -> Estimate:
    """Estimate the cost of a campaign from a short trial drive."""
    plan = campaign.plan
    missing = [cell for cell in plan.cells if not plan.done(cell, store)]
    driven = sum(cell.scenario.duration for cell in missing)
    size = sum(_bytes_per_second(cell) * cell.scenario.duration for cell in missing) if plan.keep else 0.0
    beside = KEPT if plan.keep else JUDGED
    seconds = beside * driven / _speed(missing[0]) / max(processes, 1) + START if missing else 0.0
    return Estimate(len(plan.cells), len(missing), driven / 3600.0, seconds, round(size))


def _speed(cell: Cell) -> float:
    """Simulation speed as a multiple of real time; without faults, which would start after the end of a short drive."""
    scenario = replace(cell.scenario, faults=()).with_run(seconds=min(TASTE, cell.scenario.duration))
    scenario.run()  # the first run includes the compilation
    began = time.perf_counter()
    scenario.run()
    return float(scenario.duration / (time.perf_counter() - began))


def _bytes_per_second(cell: Cell) -> float:
    """Data rate of a cell's recording without compression, which gains little on noise [byte/s]."""
    scenario = cell.scenario
    channels = channel_names(scenario.car)
    readings = sum(sensor.rate for name, sensor in scenario.sensors.items() if name in channels)
    return float(8.0 * (readings + TRUTH_RATE * len(channels)))
