"""Drives at estimate level: estimates that a monitor would have made, drawn from its measured errors.

A year of a thousand cars is 52 000 drives; where a study needs ten thousand vehicle-years, drives are not simulated.
Their estimates are drawn from the errors of the monitor on simulated drives, and every table states this.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from tierod.fleet.series import MILEAGE_UNIT, REFERENCE_TEMPERATURE, Series, Watched, stamps
from tierod.methods.trends.drive_filter import Drives
from tierod_lab.fleet.virtual import VirtualCars

if TYPE_CHECKING:
    import pyarrow as pa

WRONG = 5.0  # Ratio of the error of outlier drives to that of the others

WATCHED = Watched("friction", "", "friction torque at the steering wheel axis", "N*m")
"""Subject of the series that is drawn."""

LEAST = 4
"""Number of drives of a car that must be exceeded to fit its offset, gain and tyres and leave degrees of freedom."""


@dataclass(frozen=True)
class ErrorLaw:
    """Error model of a friction monitor over virtual cars and drives, as measured by `tierod study fleet`.

    estimate = friction + offset of the car + gain of the car * (friction - at) + tyres of the car in winter + error of
    the drive
    """

    at: Annotated[float, "N*m"]  # friction at which offset and gain are independent [N*m]
    # offset, offset_deviation: mean and standard deviation of the offset of a car [N*m]
    offset: Annotated[float, "N*m"]
    offset_deviation: Annotated[float, "N*m"]
    # gain, gain_deviation: mean and standard deviation of the gain of a car minus 1 [-], mostly of its torque sensor
    gain: Annotated[float, ""]
    gain_deviation: Annotated[float, ""]
    # winter, winter_deviation: mean and standard deviation of the effect of winter tyres [N*m]
    winter: Annotated[float, "N*m"]
    winter_deviation: Annotated[float, "N*m"]
    drive_deviation: Annotated[float, "N*m"]  # standard deviation from drive to drive of a car on the same tyres [N*m]
    stated: Annotated[float, "N*m"]  # standard deviation that a drive states, as geometric mean [N*m]
    stated_spread: Annotated[float, ""]  # standard deviation of its logarithm [-]
    judged_share: Annotated[float, ""]  # share of drives with an estimate [-]
    drives: int
    cars: int


def estimates(cars: VirtualCars, law: ErrorLaw, seed: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Draw (estimate, stated standard deviation) of every drive [N*m], (cars, drives); NaN for drives without one."""
    chance = np.random.default_rng(list(seed))
    shape, count = cars.day.shape, (len(cars.names), 1)
    gain = law.gain + law.gain_deviation * chance.standard_normal(count)
    offset = law.offset + law.offset_deviation * chance.standard_normal(count)
    winter = law.winter + law.winter_deviation * chance.standard_normal(count)
    error = law.drive_deviation * chance.standard_normal(shape)
    error *= np.where(chance.random(shape) < cars.file.wrong_share, WRONG, 1.0)
    stated = law.stated * np.exp(law.stated_spread * chance.standard_normal(shape))
    value = cars.friction + offset + gain * (cars.friction - law.at) + np.where(cars.winter, winter, 0.0) + error
    there = chance.random(shape) < law.judged_share
    return np.where(there, value, np.nan), np.where(there, stated, np.nan)


def series(cars: VirtualCars, estimate: np.ndarray, deviation: np.ndarray) -> Series:
    """Estimates as one series, without a table of findings in between."""
    from tierod.vehicles import load

    limits, count = load(cars.file.vehicle), len(cars.names)
    mileage = cars.mileage / MILEAGE_UNIT
    moved = np.stack((cars.temperature - REFERENCE_TEMPERATURE, mileage - mileage[:, :1]), axis=2)
    order = np.argsort(cars.day, axis=1)
    day, value, spread = (np.take_along_axis(each, order, axis=1) for each in (cars.day, estimate, deviation))
    return Series(
        WATCHED,
        cars.names,
        Drives(day, value, spread, np.take_along_axis(moved, order[..., None], axis=1)),
        mileage[:, 0],
        np.full(cars.day.shape, -1),
        np.full(count, float(limits["nominal_friction"])),
        np.full(count, float(limits["fault_friction"])),
        np.zeros(count),
        cars.labels,
    )


def findings_table(cars: VirtualCars, estimate: np.ndarray, deviation: np.ndarray) -> pa.Table:
    """Estimates as the findings of a fleet, for `tierod fleet report`; the column `version` states their origin."""
    import pyarrow as pa

    from tierod.fleet.schema import findings
    from tierod.vehicles import load

    limits = load(cars.file.vehicle)
    nominal, rising, limit = (float(limits[name]) for name in ("nominal_friction", "rising_friction", "fault_friction"))
    number, drive = (each.ravel() for each in np.indices(estimate.shape))
    order = np.lexsort((cars.day.ravel(), number))
    number, drive = number[order], drive[order]
    value, spread = estimate[number, drive], deviation[number, drive]
    known = np.isfinite(value)
    status = np.where(~known, "not identifiable", np.where(value >= limit, "fault", np.where(value >= rising, "rising",
                      "healthy")))  # fmt: skip
    labels = [[(kind, names[car]) for kind, names in cars.labels.items()] for car in range(len(cars.names))]
    constants: dict[str, Any] = {
        **WATCHED._asdict(), "variant": "drawn from measured errors", "role": "", "kind": "", "cause": "", "action": "",
        "span": 0, "nominal": nominal, "limit": limit, "start_s": 0.0,
        "duration_s": cars.file.duration, "judged_s": cars.file.duration, "version": "estimate level",
    }  # fmt: skip
    columns: dict[str, Any] = {
        "vehicle": pa.array(np.array(cars.names)[number].tolist()),
        "cohort": pa.array([labels[car] for car in number], pa.map_(pa.string(), pa.string())),
        "recording_name": pa.array([f"{cars.names[c]}/drive-{d + 1:04d}" for c, d in zip(number, drive, strict=True)]),
        "start": stamps(cars.day[number, drive]),
        "mileage_m": pa.array(cars.mileage[number, drive]),
        "temperature_K": pa.array(cars.temperature[number, drive]),
        "status": pa.array(status.tolist()),
        "estimate": pa.array(value, from_pandas=True),
        "deviation": pa.array(spread, from_pandas=True),
    }
    schema, rows = findings(), len(number)
    made = []
    for each in schema:
        if each.name in columns:
            made.append(columns[each.name].cast(each.type))
        elif each.name in constants:
            made.append(pa.array([constants[each.name]] * rows, each.type))
        else:
            made.append(pa.nulls(rows, each.type))
    return pa.table(made, schema=schema)


def error_law(
    car: np.ndarray, winter: np.ndarray, friction: np.ndarray, estimate: np.ndarray, stated: np.ndarray
) -> ErrorLaw:
    """Error model that fits simulated drives, by the method of moments of the analysis of variance."""
    there = np.isfinite(estimate)
    at = float(friction[there].mean())
    parts = [there & (car == number) for number in np.unique(car)]
    fits = [_fit(winter[of], friction[of] - at, (estimate - friction)[of]) for of in parts if of.sum() > LEAST]
    values, errors, freedom, unsure = (np.array(each) for each in zip(*fits, strict=True))
    variance = float(errors.sum() / freedom.sum())
    # The observed variance of the cars minus that of their estimates from few drives.
    spread = np.sqrt(np.maximum(values.var(axis=0, ddof=1) - variance * unsure.mean(axis=0), 0.0))
    mean, logs = values.mean(axis=0), np.log(stated[there])
    return ErrorLaw(
        at=at,
        offset=float(mean[0]),
        offset_deviation=float(spread[0]),
        gain=float(mean[1]),
        gain_deviation=float(spread[1]),
        winter=float(mean[2]),
        winter_deviation=float(spread[2]),
        drive_deviation=math.sqrt(variance),
        stated=float(np.exp(logs.mean())),
        stated_spread=float(logs.std(ddof=1)),
        judged_share=float(there.mean()),
        drives=len(car),
        cars=len(fits),
    )


def _fit(winter: np.ndarray, friction: np.ndarray, error: np.ndarray) -> tuple[np.ndarray, float, int, np.ndarray]:
    """(offset, gain, winter tyres) of one car, residual sum of squares, degrees of freedom, relative variances."""
    design = np.stack((np.ones(len(friction)), friction, winter.astype(float)), axis=1)
    values = np.linalg.lstsq(design, error, rcond=None)[0]
    rest = error - design @ values
    return values, float(rest @ rest), len(friction) - 3, np.diag(np.linalg.pinv(design.T @ design))
