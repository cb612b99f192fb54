"""Error of every substitute of a sensor, with calibrated parameters and with those of the shipped vehicle file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from tierod.core.content import Heading, Item, Table
from tierod.core.recording import Recording
from tierod.core.signals import SIGNALS
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.reaction import FILTER, plain_relations, substitution_graph
from tierod.monitors.condition.signals import OF_AUTOMATED, ConditionSample
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.condition import by_bank
from tierod_lab.papers.condition.drives import OFFSET, OFFSETS, TEST_SECONDS, Drive, Injected, healthy_drives
from tierod_lab.papers.condition.recorded import each, fault_free
from tierod_lab.papers.condition.reported import vehicles
from tierod_lab.papers.condition.runs import calibrations
from tierod_lab.papers.condition.vehicles import LONG, SHORT
from tierod_lab.studies.effort import Effort

TEXT = (
    "Every substitute of a sensor beside what the sensor would read without fault and noise, root mean square. The "
    "bank's filter that leaves the sensor out: from the declaration of an offset to its end, on the short and the long "
    "round. Plain relations: over fault-free drives on unseen rounds, standing and all. Both with the parameters that "
    "a calibration has found, and with those of the shipped, uncalibrated file. The table "
    "that the monitor goes by, substitutes.toml, holds these figures.",
)
HOURS = 1.0  # Fault-free driving for the plain relations [h]
SETTLED = 200  # Samples of warm-up, which are left out
SEED = 400  # First seed of the drives with offsets, which neither a calibration nor another part of the study uses

Squares = dict[tuple[str, str, bool], tuple[float, int]]
"""Sensor, substitute and whether the vehicle is calibrated -> sum of squared errors, and number of samples."""


class Error(NamedTuple):
    """Root-mean-square error of a substitute, in the unit of its sensor."""

    calibrated: float  # error with calibrated parameters
    uncalibrated: float  # error with the parameters of the shipped vehicle file


def measured(effort: Effort) -> dict[str, dict[str, Error]]:
    """The errors of all substitutes, by sensor and name."""
    chosen = vehicles(effort)
    found = calibrations(("bank",), chosen, effort)
    known = {number: found[by_bank.__name__, number] for number in chosen}
    healthy = healthy_drives(0.1 if effort.quick else HOURS, chosen)
    tests = [
        Drive(course, TEST_SECONDS, number, SEED + number, (Injected(sensor, OFFSET, OFFSETS[sensor]),))
        for number in chosen
        for course in ((SHORT,) if effort.quick else (SHORT, LONG))
        for sensor in OF_AUTOMATED
    ]
    drives = [*healthy, *tests]
    parts = each(partial(_squares, known), drives, effort)
    return {
        sensor: {way.name: Error(*(_root(parts, sensor, way.name, which) for which in (True, False))) for way in ways}
        for sensor, ways in substitution_graph().substitutes.items()
    }


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("Substitutes of the sensors", TEXT)
    rows = tuple(
        (sensor, SIGNALS[sensor].unit, name.replace("-", " "), f"{error.calibrated:.3g}", f"{error.uncalibrated:.3g}")
        for sensor, ways in measured(effort).items()
        for name, error in ways.items()
    )
    yield Table("Errors of the substitutes", ("sensor", "unit", "substitute", "calibrated", "not calibrated"), rows)


def _squares(known: Mapping[int, by_bank.Known], drive: Drive, recording: Recording) -> Squares:
    """Squared errors of one drive: of the bank's filter if a sensor fails, otherwise of the plain relations."""
    shipped = by_bank.Known(load("smartload"))
    found: Squares = {}
    for calibrated, car in ((True, known[drive.vehicle]), (False, shipped)):
        errors = _held_out(drive, recording, car) if drive.injected else _related(drive, recording, car.vehicle)
        for (sensor, name), error in errors.items():
            found[sensor, name, calibrated] = (float(error @ error), len(error))
    return found


def _held_out(drive: Drive, recording: Recording, car: by_bank.Known) -> dict[tuple[str, str], np.ndarray]:
    (fault,) = drive.injected
    declared = by_bank.declare(car, recording, "bank")
    during = declared.faulty[fault.element] & (declared.time < fault.end) & (declared.time >= fault.start)
    error = declared.value[fault.element] - fault_free(fault.element, recording, drive.driven.sensors)
    return {(fault.element, FILTER): error[during]}


def _related(drive: Drive, recording: Recording, vehicle: Vehicle) -> dict[tuple[str, str], np.ndarray]:
    readings: Any = ConditionSample(
        *(recording[name].values if name in recording else np.nan for name in ConditionSample._fields)
    )
    related = plain_relations(readings, vehicle.parameters_for(AutomatedVehicle.Parameters))
    sensors = drive.driven.sensors
    return {
        (sensor, name): (value - fault_free(sensor, recording, sensors))[SETTLED:]
        for sensor, ways in related.items()
        for name, value in ways.items()
    }


def _root(parts: list[Squares], *key: str | bool) -> float:
    sums = [part[key] for part in parts if key in part]
    count = sum(number for _, number in sums)
    return float(np.sqrt(sum(square for square, _ in sums) / count)) if count else float("nan")
