"""Series over months from the findings of a fleet: one per monitor and judged element, with one row per car."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tierod.core.statuses import Status
from tierod.methods.trends.drive_filter import Drives, gathered

if TYPE_CHECKING:
    import pyarrow as pa

REFERENCE_TEMPERATURE = 288.15  # Ambient temperature at which levels are stated [K]: 15 °C

MILEAGE_UNIT = 1e7  # Unit in which mileage is a regressor, 10 000 km, so that its coefficient is readable [m]

DAY = 86_400_000_000  # Length of a day [µs]

LEAST_DRIVES = 2  # Smallest number of drives in the whole fleet from which a quantity has a series


class Watched(NamedTuple):
    """Subject of a series."""

    monitor: str  # monitor, judged: monitor and judged element; "" for the quantity that the monitor watches as a whole
    judged: str
    quantity: str
    unit: str

    @property
    def title(self) -> str:
        """Title of the series in words."""
        about = f" of {self.judged}" if self.judged else ""
        return f"{self.quantity}{about} ({self.monitor})"


@dataclass(frozen=True, eq=False)
class Series:
    """Drives of all cars for one quantity."""

    watched: Watched
    vehicles: tuple[str, ...]  # names of the cars, in the order of the rows
    # days since 1970, estimates, standard deviations without the shared part; regressors: temperature minus the
    # reference [K], mileage since the first drive of the car [10 000 km]
    drives: Drives
    mileage: np.ndarray  # mileage at the first drive of each car [10 000 km], (cars,); NaN if unknown
    row: np.ndarray  # row of each drive in the findings, (cars, drives); -1 if there is none
    nominal: np.ndarray  # nominal, limit: nominal value and limit of each car [unit], (cars,); NaN if unknown
    limit: np.ndarray
    # standard deviation that all drives of a car share [unit], (cars,): it moves the level, and no trend
    shared: np.ndarray
    labels: Mapping[str, tuple[str, ...]]  # kind of cohort -> name of each car's cohort


def series_of(findings: pa.Table, until: float | None = None) -> tuple[list[Series], list[str]]:
    """All series of a fleet, the one with most drives first, and remarks on findings that were left out.

    Drives without a date or an estimate are no part of a trend; their verdicts still count in `standing`. What a
    monitor only estimates, such as the largest sideslip, is a property of the drive: no trend of a car follows it.
    """
    import pyarrow as pa
    import pyarrow.compute as pc

    of_drive = pc.is_in(findings["status"], pa.array([str(each) for each in Status if each.estimate]))
    code, names = _coded(findings, ("monitor", "judged", "quantity", "unit"))
    car, vehicles = _coded(findings, ("vehicle",))
    day = days(findings)
    numbers = {name: numeric(findings, name) for name in ("estimate", "deviation")}
    estimated = np.isfinite(numbers["estimate"]) & ~of_drive.to_numpy()
    future = estimated & (day > (np.inf if until is None else until))
    usable = estimated & np.isfinite(day) & ~future & np.isfinite(numbers["deviation"])
    remarks = []
    if undated := int((estimated & ~np.isfinite(day)).sum()):
        have = "finding has" if undated == 1 else "findings have"
        remarks.append(
            f"{undated} {have} no date, but a trend needs one: put the date into the file names, and run 'tierod fleet "
            "RECORDINGS --vehicles FLEET.toml -o RESULTS' with a pattern in FLEET.toml that reads (?P<start>...)"
        )
    if late := int(future.sum()):
        remarks.append(
            f"{late} findings have a date in the future and are left out of trends; set the clock of the logger"
        )
    labels = labels_of(findings, car, len(vehicles))
    found = []
    for number in np.argsort(-np.bincount(code[usable], minlength=len(names)), kind="stable"):
        rows = np.flatnonzero(usable & (code == number))
        if len(rows) >= LEAST_DRIVES:
            found.append(_series(Watched(*names[number]), findings, rows, car, day, vehicles, labels))
    return found, remarks


def _series(
    watched: Watched,
    findings: pa.Table,
    rows: np.ndarray,
    car: np.ndarray,
    day: np.ndarray,
    vehicles: Sequence[tuple[str, ...]],
    labels: Mapping[str, Sequence[str]],
) -> Series:
    part = findings.take(rows)
    of, place_of = np.unique(car[rows], return_inverse=True)
    mileage = numeric(part, "mileage_m") / MILEAGE_UNIT
    first = np.full(len(of), np.inf)
    np.minimum.at(first, place_of, np.where(np.isfinite(mileage), mileage, np.inf))
    first[~np.isfinite(first)] = np.nan
    moved = np.stack((numeric(part, "temperature_K") - REFERENCE_TEMPERATURE, mileage - first[place_of]), axis=1)
    # What all drives of a car share is no scatter from drive to drive.
    shared = np.nan_to_num(numeric(part, "shared_deviation")) if "shared_deviation" in part.column_names else 0.0
    own = np.sqrt(np.maximum(numeric(part, "deviation") ** 2 - shared**2, 0.0))
    table, place = gathered(place_of, day[rows], numeric(part, "estimate"), own, moved)
    row = np.full(table.day.shape, -1)
    row[place[:, 0], place[:, 1]] = rows
    return Series(
        watched,
        tuple(vehicles[number][0] for number in of),
        table,
        first,
        row,
        _last(numeric(part, "nominal"), place_of, len(of)),
        _last(numeric(part, "limit"), place_of, len(of)),
        np.nan_to_num(_last(shared + np.zeros(len(rows)), place_of, len(of))),
        {kind: tuple(names[number] for number in of) for kind, names in labels.items()},
    )


def _last(values: np.ndarray, car: np.ndarray, cars: int) -> np.ndarray:
    found = np.full(cars, np.nan)
    known = np.isfinite(values)
    # With repeated indices the last assignment remains.
    found[car[known]] = values[known]
    return found


def numeric(findings: pa.Table, name: str) -> np.ndarray:
    """A numeric column as an array; NaN where it is null."""
    values: np.ndarray = findings[name].to_numpy().astype(float)
    return values


def days(findings: pa.Table) -> np.ndarray:
    """Start of each drive in days since 1970; NaN without a date."""
    import pyarrow as pa
    import pyarrow.compute as pc

    column = findings["start"]
    known: np.ndarray = pc.is_valid(column).to_numpy()
    microseconds: np.ndarray = pc.fill_null(column.cast(pa.timestamp("us", tz="UTC")).cast(pa.int64()), 0).to_numpy()
    return np.where(known, microseconds / DAY, np.nan)


def stamps(days: np.ndarray) -> pa.Array:
    """Time stamps of instants in days since 1970, as `days` reads them back."""
    import pyarrow as pa

    return pa.array((days * DAY).astype(np.int64), pa.timestamp("us", tz="UTC"))


def _coded(findings: pa.Table, columns: Sequence[str]) -> tuple[np.ndarray, list[tuple[str, ...]]]:
    codes, names = [], []
    for column in columns:
        encoded = findings[column].combine_chunks().fill_null("").dictionary_encode()
        codes.append(encoded.indices.to_numpy().astype(np.int64))
        names.append([str(each) for each in encoded.dictionary.to_pylist()])
    if not len(findings):
        return np.zeros(0, np.int64), []
    unique, inverse = np.unique(np.stack(codes), axis=1, return_inverse=True)
    return inverse.ravel(), [tuple(names[i][code] for i, code in enumerate(column)) for column in unique.T]


def labels_of(findings: pa.Table, car: np.ndarray, cars: int) -> dict[str, list[str]]:
    """Name of each car's cohort by kind of cohort, from its last finding; "" if unknown."""
    kinds: dict[str, list[str]] = {}
    last = np.full(cars, -1)
    # With repeated indices the last assignment remains.
    last[car] = np.arange(len(car))
    known = last[last >= 0]
    rows: list[Any] = findings["cohort"].take(known).to_pylist()
    for number, row in zip(np.flatnonzero(last >= 0), rows, strict=True):
        for kind, name in row or ():
            kinds.setdefault(kind, [""] * cars)[number] = name or ""
    return dict(sorted(kinds.items()))
