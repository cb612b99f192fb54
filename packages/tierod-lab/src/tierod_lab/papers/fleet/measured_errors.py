"""Errors of the default friction monitor over virtual cars and drives, from which virtual estimates are drawn."""

from __future__ import annotations

import math

import numpy as np

from tierod.core.content import Table
from tierod.monitors.diagnose import diagnose
from tierod_lab.fleet.drives import VirtualDrive
from tierod_lab.fleet.estimates import ErrorLaw, error_law
from tierod_lab.papers.fleet.reported import DRIVEN, SEEDS
from tierod_lab.studies.effort import Effort

CARS, QUICK_CARS = 16, 3  # Number of cars in full and in the quick study
FRICTIONS = (4.0, 4.0, 4.0, 4.5, 5.0, 6.0)  # True friction of the drives of each car on each set of tyres [N*m]

SECONDS = 300.0  # Duration of a drive: a few minutes a week [s]

VEHICLE = "midsize-eps"


def measured(effort: Effort) -> ErrorLaw:
    """Fit the law of the errors to driven virtual cars."""
    cars = range(QUICK_CARS if effort.quick else CARS)
    first = SEEDS.of(DRIVEN, 1000 * (1 + len(cars)))[0]
    tasks = [
        VirtualDrive(first + car, first + 1000 * (car + 1) + 100 * winter + number, friction, SECONDS, bool(winter))
        for car in cars
        for winter in (0, 1)
        for number, friction in enumerate(FRICTIONS)
    ]
    found = np.array(effort.made(estimated, tasks))
    car = np.array([task.car for task in tasks])
    winter = np.array([task.winter for task in tasks])
    friction = np.array([task.friction for task in tasks])
    return error_law(car, winter, friction, found[:, 0], found[:, 1])


def estimated(task: VirtualDrive) -> tuple[float, float]:
    """Estimate and stated standard deviation of the default monitor [N*m]; NaN where it gave none."""
    estimate = diagnose(task.recording(), VEHICLE, monitor="friction").findings[0].estimate
    return (math.nan, math.nan) if estimate is None else (estimate.value, estimate.standard_deviation)


def table(law: ErrorLaw) -> Table:
    """Table of the law of the errors."""
    rows = (
        ("drives, cars", f"{law.drives}, {law.cars}", ""),
        ("offset of a car", f"{law.offset:+.3f}", f"{law.offset_deviation:.3f}"),
        ("gain of a car, less 1", f"{law.gain:+.3f}", f"{law.gain_deviation:.3f}"),
        ("winter tyres", f"{law.winter:+.3f}", f"{law.winter_deviation:.3f}"),
        ("from drive to drive", "", f"{law.drive_deviation:.3f}"),
        ("stated by the drive", "", f"{law.stated:.3f}"),
        ("share of drives with an estimate", f"{law.judged_share:.3f}", ""),
    )
    return Table(
        "Errors of the friction monitor over 5 minutes, N*m",
        ("part", "mean", "standard deviation"),
        rows,
        "Virtual cars and drives with seeds from the judged monitor; load, tyres, pressure and zeros differ from drive "
        "to drive. Drives at estimate level are drawn from these figures.",
    )
