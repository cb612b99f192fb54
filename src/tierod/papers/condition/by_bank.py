"""The bank of filters as a diagnosis of the study, calibrated as the paper's rules are: on healthy drives alone."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tierod.core.graph import Bank, Result, scan
from tierod.core.recording import Recording
from tierod.monitors.condition.bank.judge import condition_bank
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.calibration.grid import aligned
from tierod.monitors.condition.calibration.limits import NAME, design_limits, limits_of, table_of
from tierod.monitors.condition.calibration.vehicle_parameters import calibrate as calibrate_parameters
from tierod.monitors.condition.kinds.catalogue import KINDS
from tierod.monitors.condition.signals import ACTUATORS, SENSORS
from tierod.papers.condition.recorded import calibration_set
from tierod.papers.condition.truth import Declared
from tierod.vehicles import Vehicle, load


@dataclass
class Known:
    """A calibrated bank; put together where it is needed, since blocks are not sent.

    Args:
        vehicle: with the parameters and limits found
    """

    vehicle: Vehicle
    _bank: Bank | None = field(default=None, init=False, repr=False, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        """Without the blocks."""
        return {**self.__dict__, "_bank": None}

    @property
    def bank(self) -> Bank:
        """The bank at work."""
        if self._bank is None:
            self._bank = condition_bank(LeaveOutFilter.of_vehicle(self.vehicle), limits_of(self.vehicle))
        return self._bank


def calibrate(number: int, quick: bool) -> Known:
    """Parameters and limits of a vehicle, from healthy driving."""
    driven = calibration_set(number, quick)
    vehicle = calibrate_parameters(driven.fitted, load("smartload")).vehicle
    designed = design_limits(driven.healthy, vehicle)
    table = table_of(designed, f"drives of demonstrator {number}")
    return Known(replace(vehicle, thresholds={**vehicle.thresholds, NAME: table}))


def declare(known: Known, recording: Recording, name: str) -> Declared:
    """What the bank says of a drive."""
    return said_of(scan(known.bank, aligned(recording)), recording["yaw_rate"].time)


def said_of(result: Result, time: np.ndarray) -> Declared:
    """What a bank has said.

    Args:
        result: of the bank, whose output is a `Judgement`
        time: of its samples [s]
    """
    elements = (*SENSORS, *ACTUATORS)
    names = np.array(["", *KINDS])
    share = result["loss.share"]
    return Declared(
        time,
        {each: result[f"decision.faulty.{each}"] > 0.5 for each in elements},
        {each: result[f"decision.candidates.{each}"] > 0.5 for each in elements},
        {each: result[f"decision.testable.{each}"] < 0.5 for each in elements},
        {each: names[np.rint(result[f"kinds.{each}.kind"]).astype(int)] for each in SENSORS}
        | {each: np.where(result[f"decision.faulty.{each}"] > 0.5, "loss", "") for each in ACTUATORS},
        {each: result[f"kinds.{each}.size"] for each in SENSORS} | dict.fromkeys(ACTUATORS, share),
        {each: result[f"decision.value.{each}"] for each in SENSORS},
        {each: result[f"kinds.{each}.deviation"] for each in SENSORS}
        | dict.fromkeys(ACTUATORS, result["loss.deviation"]),
    )
