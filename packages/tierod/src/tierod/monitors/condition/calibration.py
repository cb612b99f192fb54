"""Calibration on fault-free driving: of a whole vehicle, and of a car that is judged by its motion alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

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
from tierod.monitors.session import Table
from tierod.vehicles import Vehicle

FOR_PARAMETERS = 300.0  # driving time at the beginning from which the parameters are estimated [s]
FAULTY = (12.0, 3.0)
"""Fast and slow mean log-likelihood ratio of a single suspect from which a drive is suspicious [nat].

In 3.4 fault-free hours of three calibrated virtual demonstrators the largest are 7.1 and 0.8; in 24 tests of each with
faulty sensors they are 16 to 20 and 5.9 to 20, the least for a tie-rod force of three times the truth for one second. A
single outlier shows in the fast mean only, and would spoil all limits.
"""
FAULTY_MOTION = (12.0, 1.0)
"""The same of a car that is judged by its motion: the fast one as for whole vehicles, the slow one at twice the usual
limit; bumps of real cars reach 3.3 and -1.7."""
LARGEST_SQUARE = 3.0  # mean NIS of a reading from which it does not fit the vehicle at all [-]
INTERVAL = 1.96  # half width of a 95 % confidence interval, in standard deviations [-]
FEWEST = 4  # least number of sensors in a drive of a car

Progress = Callable[[float], None]


@dataclass(frozen=True)
class ConditionCalibration:
    """Parameters and limits of a vehicle."""

    designed: DesignedLimits  # limits with the data of their design
    explanations: tuple[Hypothesis, ...]  # hypotheses of the limits, the fault-free one first
    thresholds: Mapping[str, Table]  # tables of thresholds for the vehicle file, by name
    remarks: tuple[str, ...]  # what the values rest on, in sentences
    doubt: str = ""  # reason why the values must not be used; "" if they may be used
    # estimated parameters with prior and 95 % interval; none of a car that is judged by its motion, whose parameters
    # 'tierod identify vehicle' estimates
    found: tuple[Found, ...] = ()
    converged: bool = True  # whether the search for the parameters has converged


class Suspicion(NamedTuple):
    """Drive that does not look fault-free: its most likely fault, and the ratio of that over its bound [-]."""

    drive: str
    suspect: str
    ratio: float


def calibrate_condition(
    recordings: Mapping[str, Recording],
    vehicle: Vehicle,
    hours_between_alarms: float = 1000.0,
    progress: Progress = lambda share: None,
) -> ConditionCalibration:
    """Calibrate parameters and limits of a vehicle on its fault-free drives, used in their order."""
    drives = healthy_drives(recordings)
    first, rest, seconds = parted(drives, FOR_PARAMETERS)
    _require_enough(seconds, rest)
    calibration = calibrate([each.recording for each in first], vehicle, lambda share: progress(0.6 * share))
    every = [*first, *rest]
    watched = watch([each.recording for each in every], calibration.vehicle, lambda share: progress(0.6 + 0.3 * share))
    after = watched[len(first) :]
    designed = designed_on(
        np.concatenate([each.blocks for each in after]), hours_between_alarms, sum(each.hours for each in after)
    )
    suspicions = suspicions_of(every, watched, hypotheses(), FAULTY)
    source = f"designed on {designed.hours:.2f} h of healthy driving of {vehicle.name}"
    further: dict[str, Table] = {}
    rules = [] if suspicions else calibrated_variants()
    for calibrated in rules:
        fitted, healthy = ([each.recording for each in part] for part in (first, rest))
        further |= calibrated(calibration.vehicle, fitted, healthy, source)
    return ConditionCalibration(
        designed,
        hypotheses(),
        {NAME: table_of(designed, source), **further},
        remarks_of(calibration, designed, seconds, bool(suspicions), bool(rules) and not further),
        doubt_of(calibration, suspicions),
        _found(calibration, vehicle),
        calibration.found.converged,
    )


def calibrated_variants() -> list[Callable[..., Mapping[str, Table]]]:
    """Calibrations of the variants that other packages provide."""
    from tierod.monitors.registry import MONITORS

    return [each.calibrate for each in MONITORS["condition"].variants.values() if each.calibrate is not None]


def _found(calibration: Calibration, before: Vehicle) -> tuple[Found, ...]:
    found = calibration.found
    rows = zip(found.names, found.values.tolist(), found.deviations.tolist(), strict=True)
    return tuple(
        Found(
            *(name, before[name], before.parameters[name].standard_deviation, value, deviation),
            *(value - INTERVAL * deviation, value + INTERVAL * deviation, "likelihood"),
        )
        for name, value, deviation in rows
    )


def remarks_of(
    calibration: Calibration, designed: DesignedLimits, seconds: float, suspicious: bool, without_rules: bool
) -> tuple[str, ...]:
    """What the parameters and limits of a whole vehicle rest on."""
    notes = [
        f"The parameters come from the first {seconds:.0f} s of driving, the limits from {designed.hours:.2f} h after "
        "them. Limits without a factor, from one half of that driving, would have been exceeded in "
        f"{designed.alarms_before} intervals of ten seconds of the other half.",
        _extrapolated(designed),
    ]
    # A fast limit beyond the largest ratio of a sample is never reached.
    pairs = zip(hypotheses()[1:], designed.limits.fast, strict=True)
    silent = [each.name for each, fast in pairs if len(each.suspects) == 1 and fast >= Weighing.largest]
    if silent and not suspicious:
        notes.append(
            f"The short-time limits of {', '.join(silent)} lie above the largest possible ratio and are never "
            "exceeded; more healthy driving, or a shorter time between false alarms, lowers them."
        )
    if without_rules:
        notes.append("The rules of the paper are not calibrated: a signal that they need is missing.")
    if not calibration.found.converged:
        notes.append("The search for the parameters did not converge; give more driving with bends and braking.")
    return tuple(notes)


def _extrapolated(designed: DesignedLimits) -> str:
    return (
        f"With limits {designed.factor:.2f} times those without a factor one false alarm is expected in "
        f"{_hours(designed.hours_between_alarms)} h, at 95 % confidence in no less than "
        f"{_hours(designed.hours_at_least)} h, if the tail continues as an exponential: only {designed.hours:.2f} h of "
        "this vehicle were observed, on these roads and in this weather."
    )


def _hours(hours: float) -> str:
    if hours > 1e6:
        return "more than 1 000 000"
    return f"{hours:,.0f}".replace(",", " ") if hours >= 10.0 else f"{hours:.1f}"


def doubt_of(calibration: Calibration, suspicions: Sequence[Suspicion]) -> str:
    """Reason why the values of a whole vehicle must not be used; "" if they may be used."""
    squares = zip(OF_AUTOMATED, calibration.found.squares, strict=False)
    if worst := {name: value for name, value in squares if not value <= LARGEST_SQUARE}:
        listed = ", ".join(f"{name} ({value:.1f})" for name, value in worst.items())
        return (
            f"the readings of {listed} do not fit the vehicle (mean squared innovation over its variance, expected "
            "about 1): check for a faulty sensor, a wrong sign or ratio, or a vehicle of another kind"
        )
    return _not_fault_free(suspicions, "check whether the vehicle file fits this car")


def _not_fault_free(suspicions: Sequence[Suspicion], remedy: str) -> str:
    if not suspicions:
        return ""
    listed = ", ".join(f"{each.drive}: {each.suspect} ({each.ratio:.1f})" for each in suspicions)
    return (
        "not fault-free, by the log-likelihood ratio of a fault over the largest in fault-free drives, expected below "
        f"1: {listed}. Leave out the faulty drives, or {remedy}"
    )


def _require_enough(seconds: float, rest: Sequence[HealthyDrive]) -> None:
    left = sum(max(each.driven - SETTLING - BLOCK, 0.0) for each in rest)
    if left < 3600.0 * LEAST_HOURS:
        whole = seconds + sum(each.driven for each in rest)
        raise InputError(
            f"the recordings hold {whole / 60.0:.1f} minutes of driving, {left / 60.0:.1f} of them for limits: the "
            f"first {FOR_PARAMETERS / 60.0:.0f} give the parameters, and limits need {60.0 * LEAST_HOURS:.0f} more, "
            f"better an hour; standing does not count, nor {SETTLING + BLOCK:.0f} s of every drive"
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


def calibrate_motion(
    recordings: Mapping[str, Recording],
    vehicle: Vehicle,
    hours_between_alarms: float = 1000.0,
    progress: Progress = lambda share: None,
) -> ConditionCalibration:
    """Design the limits of a car on its fault-free drives, with wheel speeds, yaw rate and steering angle."""
    for name, recording in recordings.items():
        _require_sensors(name, recording)
    drives, explanations = healthy_drives(recordings), hypotheses_of_cars()
    require_hours(sum(max(each.driven - SETTLING - BLOCK, 0.0) for each in drives) / 3600.0)
    base = RollingFilter.of_vehicle(vehicle)
    bank = Bank(rolling_lanes(base), Watching(rolling_decision(base, unreachable(explanations))))
    watched = watch([each.recording for each in drives], vehicle, progress, bank)
    blocks = np.concatenate([each.blocks for each in watched])
    designed = designed_on(blocks, hours_between_alarms, sum(each.hours for each in watched))
    limits, lowered = _no_wider(designed.limits, blocks)
    designed = replace(designed, limits=limits)
    source = f"designed on {designed.hours:.2f} h of fault-free driving of {vehicle.name}, by its motion"
    remarks = [
        "The car is judged by its motion alone; its parameters stay as in the file; 'tierod identify vehicle' "
        f"estimates them. The limits come from {designed.hours:.2f} h of driving.",
        _extrapolated(designed),
    ]
    if lowered:
        remarks.append(
            f"{lowered} of the {2 * len(explanations) - 2} limits were designed higher than those of a car without "
            "limits of its own and are reduced to these, since its own driving stays well below; their time between "
            "false alarms is unknown."
        )
    suspicions = suspicions_of(drives, watched, explanations, FAULTY_MOTION)
    doubt = _not_fault_free(suspicions, "identify the car first: 'tierod identify vehicle'")
    tables: Any = {NAME: table_of(designed, source, explanations)}
    return ConditionCalibration(designed, explanations, tables, tuple(remarks), doubt)


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
