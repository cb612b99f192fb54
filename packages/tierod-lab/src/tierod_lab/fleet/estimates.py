"""Drives at estimate level: estimates that a monitor would have made, drawn from its errors on simulated drives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tierod.fleet.series import MILEAGE_UNIT, REFERENCE_TEMPERATURE, Series, Watched, stamps
from tierod.methods.trends.drive_filter import Drives
from tierod_lab.fleet.virtual import VirtualCars

if TYPE_CHECKING:
    import pyarrow as pa

WRONG = 5.0  # Ratio of the error of outlier drives to that of the others

WATCHED = Watched("friction", "", "friction torque at the steering wheel axis", "N*m")
LEAST = 4  # Drives of a car beyond which its offset, gain and tyres are fitted with degrees of freedom left


@dataclass(frozen=True)
class ErrorLaw:
    """Error model of a friction monitor over virtual cars and drives, as measured by `tierod study fleet`.

    estimate = friction + offset of the car + gain of the car * (friction - at) + tyres of the car in winter + error of
    the drive; each mean is followed by its standard deviation over the cars
    """

    at: Annotated[float, "N*m"]  # friction at which offset and gain are independent
    offset: Annotated[float, "N*m"]
    offset_deviation: Annotated[float, "N*m"]
    gain: Annotated[float, ""]  # gain minus 1, mostly of the torque sensor
    gain_deviation: Annotated[float, ""]
    winter: Annotated[float, "N*m"]  # effect of winter tyres
    winter_deviation: Annotated[float, "N*m"]
    drive_deviation: Annotated[float, "N*m"]  # from drive to drive of a car on the same tyres
    stated: Annotated[float, "N*m"]  # standard deviation that a drive states, as geometric mean
    stated_spread: Annotated[float, ""]  # standard deviation of its logarithm
    judged_share: Annotated[float, ""]  # share of drives with an estimate
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
    """Estimates as findings of a fleet, for `tierod fleet report`; the column `version` states their origin."""
    import pyarrow as pa

    from tierod.fleet.schema import findings
    from tierod.vehicles import load

    limits = load(cars.file.vehicle)
    nominal, rising, limit = (float(limits[name]) for name in ("nominal_friction", "rising_friction", "fault_friction"))
    same = {
        **WATCHED._asdict(), "variant": "drawn from measured errors", "role": "", "kind": "", "cause": "", "action": "",
        "span": 0, "nominal": nominal, "limit": limit, "start_s": 0.0,
        "duration_s": cars.file.duration, "judged_s": cars.file.duration, "version": "estimate level",
    }  # fmt: skip
    rows = []
    for car, name in enumerate(cars.names):
        cohort = [(kind, names[car]) for kind, names in cars.labels.items()]
        starts = stamps(cars.day[car]).to_pylist()
        for drive in np.argsort(cars.day[car]).tolist():
            value, spread = float(estimate[car, drive]), float(deviation[car, drive])
            status = "fault" if value >= limit else "rising" if value >= rising else "healthy"
            known = {"status": status, "estimate": value, "deviation": spread}
            rows.append({
                **same, "vehicle": name, "cohort": cohort, "recording_name": f"{name}/drive-{drive + 1:04d}",
                "start": starts[drive], "mileage_m": float(cars.mileage[car, drive]),
                "temperature_K": float(cars.temperature[car, drive]),
                **(known if math.isfinite(value) else {"status": "not identifiable"}),
            })  # fmt: skip
    return pa.Table.from_pylist(rows, schema=findings())


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
    names = ("offset", "gain", "winter")
    known = {name: float(value) for name, value in zip(names, mean, strict=True)}
    known |= {f"{name}_deviation": float(value) for name, value in zip(names, spread, strict=True)}
    known |= {"stated": float(np.exp(logs.mean())), "stated_spread": float(logs.std(ddof=1))}
    known |= {"drive_deviation": math.sqrt(variance), "judged_share": float(there.mean())}
    return ErrorLaw(at=at, **known, drives=len(car), cars=len(fits))


def _fit(winter: np.ndarray, friction: np.ndarray, error: np.ndarray) -> tuple[np.ndarray, float, int, np.ndarray]:
    """(offset, gain, winter tyres) of one car, residual sum of squares, degrees of freedom, relative variances."""
    design = np.stack((np.ones(len(friction)), friction, winter.astype(float)), axis=1)
    values = np.linalg.lstsq(design, error, rcond=None)[0]
    rest = error - design @ values
    return values, float(rest @ rest), len(friction) - 3, np.diag(np.linalg.pinv(design.T @ design))
