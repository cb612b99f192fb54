"""Calibration of the limits of a car that is judged by its motion alone, on its own fault-free drives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import Bank
from tierod.core.recording import Recording
from tierod.methods.identification.experiment import Found
from tierod.monitors.condition.bank.rolling_filter import RollingFilter
from tierod.monitors.condition.bank.weighing import Limits
from tierod.monitors.condition.calibration.healthy_drives import healthy_drives
from tierod.monitors.condition.calibration.healthy_ratios import (
    BLOCK,
    SETTLING,
    Watching,
    unreachable,
    watch,
)
from tierod.monitors.condition.calibration.limits import (
    FACTOR,
    NAME,
    DesignedLimits,
    designed_on,
    require_hours,
    table_of,
)
from tierod.monitors.condition.calibration.whole import Suspicion, remark_of_limits, suspicions_of
from tierod.monitors.condition.hypotheses import Hypothesis, hypotheses_of_cars
from tierod.monitors.condition.monitor import rolling_decision, rolling_lanes, rolling_limits
from tierod.monitors.condition.signals import OF_CARS
from tierod.monitors.harness.session import Table
from tierod.vehicles import Vehicle

FAULTY = (12.0, 1.0)
"""Fast and slow mean log-likelihood ratio of a single suspect from which a drive is suspicious [nat]; the fast one as
for whole vehicles, the slow one at twice the usual limit; bumps of real cars reach 3.3 and -1.7."""
FEWEST = 4
"""Least number of sensors in a drive."""


@dataclass(frozen=True)
class MotionCalibration:
    """Limits of a car that is judged by its motion.

    Args:
        designed: limits with the data of their design
        before: vehicle before the calibration
        lowered: number of limits that were lowered to those of a car without limits of its own
        suspicions: drives that do not look fault-free
    """

    designed: DesignedLimits
    before: Vehicle
    lowered: int
    suspicions: tuple[Suspicion, ...] = ()

    found: ClassVar[tuple[Found, ...]] = ()
    """Estimated parameters: none, since 'tierod identify vehicle' estimates those of a car."""
    converged: ClassVar[bool] = True

    @property
    def explanations(self) -> tuple[Hypothesis, ...]:
        """Hypotheses of the limits, the fault-free one first."""
        return hypotheses_of_cars()

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on the calibration."""
        count = len(self.explanations) - 1
        return (
            "The car is judged by its motion alone; its parameters stay as in the file; 'tierod identify vehicle' "
            f"estimates them. The limits come from {self.designed.hours:.2f} h of driving.",
            remark_of_limits(self.designed),
            f"{self.lowered} of the {2 * count} limits were designed higher than those of a car without limits of its "
            "own and are reduced to these, since its own driving stays well below; their time between false alarms is "
            "unknown.",
        )[: 3 if self.lowered else 2]

    @property
    def doubt(self) -> str:
        """Reason why the limits must not be used; "" if they may be used."""
        if not self.suspicions:
            return ""
        listed = ", ".join(f"{each.drive}: {each.suspect} ({each.ratio:.1f})" for each in self.suspicions)
        return (
            "not fault-free, by the log-likelihood ratio of a fault over the largest in fault-free drives, expected "
            f"below 1: {listed}. Leave out the faulty drives, or identify the car first: 'tierod identify vehicle'"
        )

    @property
    def thresholds(self) -> Mapping[str, Table]:
        """Tables of thresholds for the vehicle file, by name."""
        source = f"designed on {self.designed.hours:.2f} h of fault-free driving of {self.before.name}, by its motion"
        return {NAME: table_of(self.designed, source, self.explanations)}


def calibrate_motion(
    recordings: Mapping[str, Recording],
    vehicle: Vehicle,
    hours_between_alarms: float = 1000.0,
    progress: Callable[[float], None] = lambda share: None,
) -> MotionCalibration:
    """Design the limits of a car on its fault-free drives, with wheel speeds, yaw rate and steering angle.

    Args:
        recordings: recordings of fault-free driving by name, a quarter of an hour or, better, hours
        vehicle: vehicle with the parameters of `RollingCar`
        hours_between_alarms: required mean time between false alarms [h]
        progress: called with the completed share, 0 to 1

    Raises:
        InputError: too little driving, the same drive twice, or a recording with fewer than four of the sensors
        ParameterError: parameters are missing
    """
    for name, recording in recordings.items():
        _require_sensors(name, recording)
    drives = healthy_drives(recordings)
    require_hours(sum(max(each.driven - SETTLING - BLOCK, 0.0) for each in drives) / 3600.0)
    base = RollingFilter.of_vehicle(vehicle)
    decision = rolling_decision(base, unreachable(hypotheses_of_cars()))
    bank = Bank(rolling_lanes(base), Watching(decision))
    watched = watch([each.recording for each in drives], vehicle, progress, bank)
    blocks = np.concatenate([each.blocks for each in watched])
    designed = designed_on(blocks, hours_between_alarms, sum(each.hours for each in watched))
    limits, lowered = _no_wider(designed.limits, blocks)
    designed = replace(designed, limits=limits)
    return MotionCalibration(designed, vehicle, lowered, suspicions_of(drives, watched, hypotheses_of_cars(), FAULTY))


def _no_wider(limits: Limits, blocks: np.ndarray) -> tuple[Limits, int]:
    """Limits reduced to those for any car where its own driving stays well below these; and the number of them."""
    usual, largest = rolling_limits(), np.split(blocks.max(axis=0), 2)
    columns, lowered = [], 0
    for own, known, seen in zip((limits.fast, limits.slow), (usual.fast, usual.slow), largest, strict=True):
        kept = np.maximum(known, FACTOR * seen)
        lowered += int(np.count_nonzero(kept < own))
        columns.append(tuple(np.minimum(own, kept).tolist()))
    return replace(limits, fast=columns[0], slow=columns[1]), lowered


def _require_sensors(name: str, recording: Recording) -> None:
    there = [each for each in OF_CARS if each in recording and np.isfinite(recording[each].values).any()]
    if len(there) < FEWEST:
        missing = ", ".join(each for each in OF_CARS if each not in there)
        raise InputError(
            f"{name} has {len(there)} of the sensors that a car is judged by, but {FEWEST} are needed; it lacks "
            f"{missing}. 'tierod inspect' shows what the recording has; name them in the channel map"
        )
