"""Identification of a vehicle from ordinary drives: identified parameters, and the drives needed for the others."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from tierod.core.content import Heading, Item, Table
from tierod.core.errors import ParameterError
from tierod.core.recording import Recording
from tierod.methods.identification.drives import SIGNALS
from tierod.methods.identification.vehicle import VehicleIdentification, Zeros
from tierod.methods.identification.vehicle_judgement import LEARNT
from tierod.monitors.condition.calibration import ConditionCalibration, calibrate_condition, calibrate_motion
from tierod.monitors.condition.signals import ConditionSample, rolls
from tierod.monitors.friction.signals import SteeringSample
from tierod.monitors.own_car import identify_own_car
from tierod.report.display import number
from tierod.report.identification import Subject, correlations, found_table
from tierod.vehicles import QUANTITIES, Vehicle

_BEYOND = "They include errors of the model, which longer driving does not remove."


def _vehicle(
    car: Vehicle, recordings: dict[str, Recording], free: tuple[str, ...], advance: Any
) -> VehicleIdentification:
    return identify_own_car(recordings, car, free, advance)


def _items(result: VehicleIdentification) -> Iterator[Item]:
    learnt, count = sum(each.kind == LEARNT for each in result.judged), len(result.drives)
    learnt_from = f"{learnt} of {len(result.judged)} parameters learnt from {count} drive{'s' if count > 1 else ''}."
    yield found_table(result.found, f"{_BEYOND} {learnt_from}")
    yield _rest(result)
    yield _drives(result)
    yield Heading("Noises", ("Found from the innovations of the filter, beside the parameters.",))
    rows = tuple((name.replace("_", " "), number(value, 3), number(s, 2)) for name, (value, s) in result.noises.items())
    yield Table("Noises of sensors, model and road", ("noise", "value", "σ"), rows)
    every = [prior.name for prior in result.posterior.priors]
    names = [each.name for each in result.judged if each.name in every]
    places = [every.index(name) for name in names]
    yield correlations("Correlation of the parameters", names, result.posterior.covariance[np.ix_(places, places)])


def _rest(result: VehicleIdentification) -> Table:
    rows = tuple(
        (each.name, f"{number(each.before)} ± {number(each.before_deviation, 2)}", each.text)
        for each in result.judged
        if each.kind != LEARNT
    )
    return Table("Kept as before", ("parameter", "before", "why"), rows, "A number in brackets is a correlation.")


def _drives(result: VehicleIdentification) -> Table:
    rows = tuple(
        (drive.name, f"{drive.driven / 60.0:.1f}", *_zero_cells(zeros))
        for drive, zeros in zip(result.drives, result.zeros, strict=True)
    )
    header = ("drive", "min", "steering zero (°)", "yaw rate zero (°/s)", "lateral zero (m/s²)")
    note = "Readings without motion; a road that falls to one side adds to the first and to the third."
    return Table("Drives and their zeros", header, rows, note)


def _zero_cells(zeros: Zeros) -> tuple[str, str, str]:
    steering, yaw = (tuple(map(math.degrees, each)) for each in (zeros.steering, zeros.yaw_rate))
    pairs = (steering, yaw, zeros.lateral_acceleration)
    cells = [f"{value:.3f} ± {deviation:.3f}".replace("-", "−") for value, deviation in pairs]
    return cells[0], cells[1], cells[2]


def _document(result: VehicleIdentification) -> dict[str, Any]:
    return {
        "judged": [
            {
                "name": each.name,
                "unit": QUANTITIES[each.name].unit,
                "kind": each.kind,
                "before": each.before,
                "before_standard_deviation": each.before_deviation,
                "value": each.value,
                "standard_deviation": each.deviation,
                "why": each.text,
            }
            for each in result.judged
        ],
        "drives": [
            {"name": drive.name, "driven_s": drive.driven, "zeros": zeros._asdict()}
            for drive, zeros in zip(result.drives, result.zeros, strict=True)
        ],
        "noises": {name: {"value": v, "standard_deviation": s} for name, (v, s) in result.noises.items()},
        "contradictions": [each._asdict() for each in result.contradictory],
        "odd_drive": result.odd and result.drives[result.odd.drive].name,
        "converged": result.posterior.converged,
        "doubt": result.doubt,
    }


def _signals() -> tuple[str, ...]:
    return tuple(dict.fromkeys((*SIGNALS, *SteeringSample._fields)))


VEHICLE = Subject(
    "Vehicle",
    "Most probable parameters of a vehicle given its file and ordinary drives. What the drives do not show keeps the "
    "value and the standard deviation that it had.",
    _vehicle,
    _items,
    _document,
    signals=_signals,
)


def _thresholds(
    car: Vehicle,
    recordings: dict[str, Recording],
    free: tuple[str, ...],
    advance: Callable[[float], None],
    hours: float = 1000.0,
) -> ConditionCalibration:
    if free:
        raise ParameterError("thresholds are found with all parameters that fault-free driving shows; leave --free out")
    if rolls(car):
        return calibrate_motion(recordings, car, hours, advance)
    return calibrate_condition(recordings, car, hours, advance)


def _thresholds_signals() -> tuple[str, ...]:
    return tuple(ConditionSample._fields)


def _thresholds_items(result: ConditionCalibration) -> Sequence[Table]:
    limits = result.designed.limits
    pairs = zip(result.explanations[1:], limits.fast, limits.slow, strict=True)
    rows = tuple(
        (each.name.replace("_", " "), number(fast, 3), number(slow, 3))
        for each, fast, slow in pairs
        if len(each.suspects) == 1
    )
    note = "Mean log-likelihood ratio per sample, over 0.05 and 0.5 s, beyond which a fault is declared."
    found = [found_table(result.found)] if result.found else []
    return [*found, Table("Limits", ("suspect", "over 0.05 s", "over 0.5 s"), rows, note)]


def _thresholds_document(result: ConditionCalibration) -> dict[str, Any]:
    return {"thresholds": result.thresholds, "converged": result.converged, "explained": not result.doubt}


THRESHOLDS = Subject(
    "Thresholds",
    "Maximum-likelihood parameters of an automated vehicle for the filter of all its sensors in fault-free driving, "
    "from the first five minutes; limits of the condition monitor from all driving after them, for a wanted mean "
    "time between false alarms. Of a car that is judged by its motion alone: limits from all its driving.",
    _thresholds,
    _thresholds_items,
    _thresholds_document,
    takes_false_alarms=True,
    signals=_thresholds_signals,
)
