"""The bank of filters as a diagnosis of the study, calibrated like the paper's rules on fault-free drives alone."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tierod.core.graph import Bank, Result, scan
from tierod.core.recording import Recording
from tierod.core.statuses import Status, code_of
from tierod.monitors.condition.definition import condition_monitor
from tierod.monitors.condition.kinds import KINDS
from tierod.monitors.condition.limits import NAME, aligned, designed_on, table_of, watch
from tierod.monitors.condition.parameters import calibrate as calibrate_parameters
from tierod.monitors.condition.signals import ELEMENTS, SENSORS
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.condition.recorded import calibration_set
from tierod_lab.papers.condition.truth import Declared


@dataclass
class Known:
    """A calibrated bank, which each process builds on first use, since blocks are not pickled."""

    vehicle: Vehicle  # vehicle with calibrated parameters and limits
    _bank: Bank | None = field(default=None, init=False, repr=False, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_bank": None}

    @property
    def bank(self) -> Bank:
        """The bank of the vehicle."""
        if self._bank is None:
            self._bank = condition_monitor(self.vehicle)
        return self._bank


def calibrate(number: int, quick: bool) -> Known:
    """Calibrates parameters and limits of a vehicle on its fault-free drives."""
    driven = calibration_set(number, quick)
    vehicle = calibrate_parameters(driven.fitted, load("smartload")).vehicle
    watched = watch(driven.healthy, vehicle)
    blocks, hours = np.concatenate([each.blocks for each in watched]), sum(each.hours for each in watched)
    designed = designed_on(blocks, 1000.0, hours)
    table = table_of(designed, f"drives of demonstrator {number}")
    return Known(replace(vehicle, thresholds={**vehicle.thresholds, NAME: table}))


def declare(known: Known, recording: Recording, name: str) -> Declared:
    """Declarations of the bank over a drive."""
    return declared_of(scan(known.bank, aligned(recording)), recording["yaw_rate"].time)


def declared_of(result: Result, time: np.ndarray) -> Declared:
    """Declarations of any variant of the monitor.

    Args:
        time: sampling times [s]
    """
    # The last kind, an actuator's loss of torque, is called a loss by the faults of the study.
    names = np.array(["", *KINDS[:-1], "loss"])
    status, kind, magnitude, deviation = (
        {each: result[f"statements.{each}.{part}"] for each in ELEMENTS}
        for part in ("status", "kind", "magnitude", "deviation")
    )
    return Declared(
        time,
        {each: codes == code_of(Status.FAULT) for each, codes in status.items()},
        {each: codes == code_of(Status.SUSPECT) for each, codes in status.items()},
        {each: result[f"testable.{each}"] < 0.5 for each in ELEMENTS},
        {each: names[np.rint(numbers).astype(int)] for each, numbers in kind.items()},
        magnitude,
        {each: result[f"value.{each}"] for each in SENSORS},
        deviation,
    )
