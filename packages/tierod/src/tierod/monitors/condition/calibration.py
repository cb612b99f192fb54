"""Calibration on fault-free driving: of a whole vehicle, and of a car that is judged by its motion alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import Bank
from tierod.core.recording import Recording
from tierod.methods.identification.experiment import Found
from tierod.monitors.condition.definition import rolling_decision, rolling_lanes, rolling_limits
from tierod.monitors.condition.limits import (
    BLOCK,
    FACTOR,
    LEAST_HOURS,
    NAME,
    SETTLING,
    DesignedLimits,
    HealthyDrive,
    Watched,
    Watching,
    designed_on,
    healthy_drives,
    parted,
    require_hours,
    table_of,
    unreachable,
    watch,
)
from tierod.monitors.condition.parameters import Calibration, calibrate
from tierod.monitors.condition.rolling_filter import RollingFilter
from tierod.monitors.condition.signals import OF_AUTOMATED, OF_CARS, Hypothesis, hypotheses, hypotheses_of_cars
from tierod.monitors.condition.weighing import Limits, Weighing
from tierod.monitors.harness.session import Table
from tierod.vehicles import Vehicle

FOR_PARAMETERS = 300.0  # driving time at the beginning from which the parameters are estimated [s]
FAULTY = (12.0, 3.0)
"""Fast and slow mean log-likelihood ratio of a single suspect from which a drive is suspicious [nat].

In 3.4 fault-free hours of three calibrated virtual demonstrators the largest are 7.1 and 0.8; in 24 tests of each with
faulty sensors they are 16 to 20 and 5.9 to 20, the least for a tie-rod force of three times the truth for one second. A
single outlier shows in the fast mean only, and would spoil all limits.
"""
LARGEST_SQUARE = 3.0  # mean NIS of a reading from which it does not fit the vehicle at all [-]
INTERVAL = 1.96  # half width of a 95 % confidence interval, in standard deviations [-]


class Suspicion(NamedTuple):
    """Drive that does not look fault-free.

    Args:
        drive: name of the drive
        suspect: most likely faulty sensor or actuator
        ratio: mean log-likelihood ratio of its fault over the bound for fault-free drives [-]
    """

    drive: str
    suspect: str
    ratio: float


@dataclass(frozen=True)
class ConditionCalibration:
    """Parameters and limits of a vehicle.

    Args:
        calibration: estimated parameters
        designed: limits with the data of their design
        further: tables of thresholds of other variants by name; empty if a signal that they need is missing
        before: vehicle before the calibration
        seconds: driving time from which the parameters are estimated
        suspicions: drives that do not look fault-free
    """

    calibration: Calibration
    designed: DesignedLimits
    further: Mapping[str, Table]
    before: Vehicle
    seconds: Annotated[float, "s"]
    suspicions: tuple[Suspicion, ...] = ()

    @property
    def found(self) -> tuple[Found, ...]:
        """Estimated parameters with prior and 95 % interval, in the order of `FREE`."""
        found = self.calibration.found
        rows = zip(found.names, found.values.tolist(), found.deviations.tolist(), strict=True)
        return tuple(
            Found(
                name,
                self.before[name],
                self.before.parameters[name].standard_deviation,
                value,
                deviation,
                value - INTERVAL * deviation,
                value + INTERVAL * deviation,
                "likelihood",
            )
            for name, value, deviation in rows
        )

    @property
    def explanations(self) -> tuple[Hypothesis, ...]:
        return hypotheses()

    @property
    def converged(self) -> bool:
        return self.calibration.found.converged

    @property
    def remarks(self) -> tuple[str, ...]:
        designed = self.designed
        rest = designed.hours
        notes = [
            f"The parameters come from the first {self.seconds:.0f} s of driving, the limits from {rest:.2f} h after "
            "them. Limits without a factor, from one half of that driving, would have been exceeded in "
            f"{designed.alarms_before} intervals of ten seconds of the other half.",
            remark_of_limits(designed),
        ]
        silent = self._silent()
        if silent and not self.suspicions:
            notes.append(
                f"The short-time limits of {', '.join(silent)} lie above the largest possible ratio and are never "
                "exceeded; more healthy driving, or a shorter time between false alarms, lowers them."
            )
        if _calibrated_variants() and not self.further and not self.suspicions:
            notes.append("The rules of the paper are not calibrated: a signal that they need is missing.")
        if not self.calibration.found.converged:
            notes.append("The search for the parameters did not converge; give more driving with bends and braking.")
        return tuple(notes)

    def _silent(self) -> list[str]:
        """Single suspects with a fast limit beyond the largest ratio of a sample, which is therefore never reached."""
        pairs = zip(hypotheses()[1:], self.designed.limits.fast, strict=True)
        return [each.name for each, fast in pairs if len(each.suspects) == 1 and fast >= Weighing.largest]

    @property
    def doubt(self) -> str:
        """Reason why the values must not be used; "" if they may be used."""
        worst = {
            name: value
            for name, value in zip(OF_AUTOMATED, self.calibration.found.squares, strict=False)
            if not value <= LARGEST_SQUARE
        }
        if worst:
            listed = ", ".join(f"{name} ({value:.1f})" for name, value in worst.items())
            return (
                f"the readings of {listed} do not fit the vehicle (mean squared innovation over its variance, expected "
                "about 1): check for a faulty sensor, a wrong sign or ratio, or a vehicle of another kind"
            )
        if self.suspicions:
            listed = ", ".join(f"{each.drive}: {each.suspect} ({each.ratio:.1f})" for each in self.suspicions)
            return (
                "not healthy, by the log-likelihood ratio of a fault over the largest in fault-free drives, expected "
                f"below 1: {listed}. Leave out the faulty drives, or check whether the vehicle file fits this car"
            )
        return ""

    @property
    def thresholds(self) -> Mapping[str, Table]:
        return {NAME: table_of(self.designed, _source(self.designed, self.before)), **self.further}


def _source(designed: DesignedLimits, vehicle: Vehicle) -> str:
    return f"designed on {designed.hours:.2f} h of healthy driving of {vehicle.name}"


def calibrate_condition(
    recordings: Mapping[str, Recording],
    vehicle: Vehicle,
    hours_between_alarms: float = 1000.0,
    progress: Callable[[float], None] = lambda share: None,
) -> ConditionCalibration:
    """Calibrate parameters and limits of a vehicle on its fault-free drives, used in their order."""
    drives = healthy_drives(recordings)
    first, rest, seconds = parted(drives, FOR_PARAMETERS)
    _require_enough(seconds, rest)
    calibration = calibrate([each.recording for each in first], vehicle, lambda share: progress(0.6 * share))
    found = calibration.vehicle
    watched = watch([each.recording for each in (*first, *rest)], found, lambda share: progress(0.6 + 0.3 * share))
    after = watched[len(first) :]
    designed = designed_on(
        np.concatenate([each.blocks for each in after]), hours_between_alarms, sum(each.hours for each in after)
    )
    suspicions = suspicions_of([*first, *rest], watched, hypotheses(), FAULTY)
    further: dict[str, Table] = {}
    if not suspicions:
        fitted, healthy = ([each.recording for each in part] for part in (first, rest))
        for calibrated in _calibrated_variants():
            further |= calibrated(found, fitted, healthy, _source(designed, vehicle))
    return ConditionCalibration(calibration, designed, further, vehicle, seconds, suspicions)


def _calibrated_variants() -> list[Callable[..., Mapping[str, Table]]]:
    """Calibrations of the variants that other packages provide."""
    from tierod.monitors.registry import MONITORS

    return [each.calibrate for each in MONITORS["condition"].variants.values() if each.calibrate is not None]


def _require_enough(seconds: float, rest: Sequence[HealthyDrive]) -> None:
    left = sum(max(each.driven - SETTLING - BLOCK, 0.0) for each in rest)
    if left < 3600.0 * LEAST_HOURS:
        whole = seconds + sum(each.driven for each in rest)
        raise InputError(
            f"the recordings hold {whole / 60.0:.1f} minutes of driving, {left / 60.0:.1f} of them for limits: the "
            f"first {FOR_PARAMETERS / 60.0:.0f} give the parameters, and limits need {60.0 * LEAST_HOURS:.0f} more, "
            f"better an hour; standing does not count, nor {SETTLING + BLOCK:.0f} s of every drive"
        )


def remark_of_limits(designed: DesignedLimits) -> str:
    """Remark on the extrapolated false alarm rate of the limits, and on the driving time of their design."""
    return (
        f"With limits {designed.factor:.2f} times those without a factor one false alarm is expected in "
        f"{_hours(designed.hours_between_alarms)} h, at 95 % confidence in no less than "
        f"{_hours(designed.hours_at_least)} h, if the tail continues as an exponential: only {designed.hours:.2f} h of "
        "this vehicle were observed, on these roads and in this weather."
    )


def suspicions_of(
    drives: Sequence[HealthyDrive],
    watched: Sequence[Watched],
    explanations: Sequence[Hypothesis],
    faulty: tuple[float, float],
) -> tuple[Suspicion, ...]:
    """Most likely single fault of every drive that does not look fault-free."""
    faults = explanations[1:]
    single = [k for k, each in enumerate(faults) if len(each.suspects) == 1]
    found: dict[str, Suspicion] = {}
    for drive, seen in zip(drives, watched, strict=True):
        if not len(seen.blocks):
            continue
        fast, slow = np.split(seen.blocks.max(axis=0), 2)
        ratios = np.maximum(fast[single] / faulty[0], slow[single] / faulty[1])
        worst = int(np.argmax(ratios))
        each = Suspicion(drive.name, faults[single[worst]].name, float(ratios[worst]))
        if each.ratio > max(1.0, found[drive.name].ratio if drive.name in found else 0.0):
            found[drive.name] = each
    return tuple(found.values())


def _hours(hours: float) -> str:
    if hours > 1e6:
        return "more than 1 000 000"
    return f"{hours:,.0f}".replace(",", " ") if hours >= 10.0 else f"{hours:.1f}"


FAULTY_MOTION = (12.0, 1.0)
"""Fast and slow mean log-likelihood ratio of a single suspect from which a drive is suspicious [nat]; the fast one as
for whole vehicles, the slow one at twice the usual limit; bumps of real cars reach 3.3 and -1.7."""
FEWEST = 4  # least number of sensors in a drive


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
        return hypotheses_of_cars()

    @property
    def remarks(self) -> tuple[str, ...]:
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
        source = f"designed on {self.designed.hours:.2f} h of fault-free driving of {self.before.name}, by its motion"
        return {NAME: table_of(self.designed, source, self.explanations)}


def calibrate_motion(
    recordings: Mapping[str, Recording],
    vehicle: Vehicle,
    hours_between_alarms: float = 1000.0,
    progress: Callable[[float], None] = lambda share: None,
) -> MotionCalibration:
    """Design the limits of a car on its fault-free drives, with wheel speeds, yaw rate and steering angle."""
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
    return MotionCalibration(
        designed, vehicle, lowered, suspicions_of(drives, watched, hypotheses_of_cars(), FAULTY_MOTION)
    )


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
