"""Courses by name, from tables of a recording, and from files: demands on a car and its driver, with road and wind."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Annotated, get_type_hints

import numpy as np

from tierod.core.block import units
from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.files import expanded
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod.core.units import Scale, scale
from tierod.core.user_files import MOST_DATA_BYTES, read_text
from tierod_lab.ground.courses.bench import BenchHands, BenchMultisine, BenchRamps, BenchSteps, BenchSweep
from tierod_lab.ground.courses.course import Columns, combine
from tierod_lab.ground.courses.manoeuvres import (
    AngleRamp,
    DoubleLaneChange,
    LockToLock,
    RandomSteer,
    SineSteer,
    Slalom,
    SteadyAngle,
    SteadyCircle,
    StepSteer,
    StraightLane,
)
from tierod_lab.ground.courses.roads import Circuit, DrawnRound, NaturalDrive
from tierod_lab.ground.courses.way import STEP, TimeCourse, Way, WayCourse, require_some
from tierod_lab.ground.parts import Demand, Road, Wind

PLACES = {"time": "s", "distance": "m", "x": "m", "y": "m"}
_HEADING = re.compile(r"\s*(\w+)\s*(?:\[(.*)\])?\s*")


@cache
def known_columns() -> dict[str, tuple[str, str]]:
    """(dotted name, unit) by the short name in files."""
    return {
        name: (f"{part}.{name}", unit)
        for part, kind in (("road", Road), ("wind", Wind), ("demand", Demand))
        for name, unit in zip(get_type_hints(kind), units(kind), strict=True)
    }


def read_table(path: str | Path) -> tuple[str, dict[str, np.ndarray]]:
    """Description (from lines that start with #) and columns in SI units by short name.

    The first line that is not a comment names the columns, with a unit if it is not the SI unit: `speed [km/h]`.
    """
    path = Path(path)
    lines = read_text(path, "the course file", ParameterError, "give a CSV file", MOST_DATA_BYTES).splitlines()
    remarks = [line.lstrip("# ").strip() for line in lines if line.startswith("#")]
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    if len(rows) < 3:
        raise ParameterError(f"{path}: a course needs a line of column names and at least two rows of numbers")
    (line, header), *body = rows
    scales = _heading(header, f"{path}, line {line}")
    values = np.array([_numbers(text, len(scales), f"{path}, line {number}") for number, text in body])
    columns = {
        name: np.asarray(convert(own), float) for (name, convert), own in zip(scales.items(), values.T, strict=True)
    }
    for name in ("time", "distance"):
        back = np.flatnonzero(np.diff(columns.get(name, np.arange(2.0))) <= 0.0)
        if back.size:
            raise ParameterError(f"{path}, line {body[back[0] + 1][0]}: the {name} does not grow; sort the rows by it")
    return " ".join(remarks), columns


def _heading(header: str, where: str) -> dict[str, Scale]:
    known = PLACES | {name: unit for name, (_, unit) in known_columns().items()}
    scales: dict[str, Scale] = {}
    for text in next(csv.reader([header])):
        match = _HEADING.fullmatch(text)
        name, unit = match.groups() if match else (text.strip(), None)
        if name not in known:
            raise ParameterError(f"{where}: no column is called '{name}'{nearest(name, known)}")
        if name in scales:
            raise ParameterError(f"{where}: the column '{name}' is there twice; leave one out")
        try:
            scales[name] = scale(known[name] if unit is None else unit, known[name])
        except InputError as error:
            raise ParameterError(f"{where}: column '{name}': {error}") from None
    return scales


def _numbers(text: str, count: int, where: str) -> list[float]:
    fields = next(csv.reader([text]))
    if len(fields) != count:
        raise ParameterError(f"{where}: {len(fields)} values, but there are {count} columns")
    try:
        values = [float(field) for field in fields]
    except ValueError as error:
        raise ParameterError(f"{where}: {error}; write numbers with a decimal point") from None
    if not all(map(math.isfinite, values)):
        raise ParameterError(f"{where}: a value is not finite; give a number in every row")
    return values


Curve = Callable[[np.ndarray], np.ndarray]  # Curvature [1/m] as a function of distance [m]
SHORTEST = 1.0  # Minimum length of a way [m]
_SLOPES = ("bank_angle", "grade_angle")


@dataclass(frozen=True)
class TimeTable(TimeCourse):
    """Speed, steering-wheel angle and other inputs over time, linear between the rows."""

    file: str = ""  # CSV file with a column `time`; without a column `attention` the driver follows no lane

    @cached_property
    def _table(self) -> dict[str, np.ndarray]:
        return _read(self.file, "time")

    @property
    def duration(self) -> float:
        return float(self._table["time"][-1])

    def speed_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        instants = self._table["time"]
        speed = self._table.get("speed", np.zeros(len(instants)))
        rise = np.concatenate([[0.0], np.diff(speed) / np.diff(instants), [0.0]])
        return np.interp(time, instants, speed), rise[np.searchsorted(instants, time, side="right")]

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        instants = self._table["time"]
        angle = self._table.get("steering_wheel_angle", np.zeros(len(instants)))
        return np.asarray(np.interp(time, instants, angle))

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        columns = super().columns(time, distance, speed, ahead)
        table, dotted = self._table, known_columns()
        if "attention" in table:
            del columns["demand.attention"]
        own = [name for name in table if name not in (*PLACES, "speed", "steering_wheel_angle")]
        combine(columns, {dotted[name][0]: np.interp(time, table["time"], table[name]) for name in own})
        return columns


@dataclass(frozen=True)
class WayTable(WayCourse):
    """A road as linear rows of `distance` and `curvature`, or of points `x` and `y` joined by a spline."""

    file: str = ""  # CSV file; columns `speed`, `bank_angle` and `grade_angle` limit the speed and tilt the road
    speed: Annotated[float, "m/s", POSITIVE] = 50.0 / 3.6
    lateral_acceleration: Annotated[float, "m/s**2", POSITIVE] = 3.0
    wait: Annotated[float, "s", NOT_NEGATIVE] = 0.0  # time at rest before the start; 0 starts rolling
    laps: int = 1

    def __post_init__(self) -> None:
        require_some("laps", self.laps)

    @cached_property
    def way(self) -> Way:
        table = _read(self.file, "distance or x")
        gone, curvature = _line(table, self.file)
        if gone[-1] < SHORTEST:
            raise ParameterError(f"{self.file}: the way is {gone[-1]:.2g} m long; give at least {SHORTEST:g} m")
        place = np.arange(0.0, gone[-1], STEP)
        count = len(place) * self.laps
        limit = np.minimum(np.interp(place, gone, table["speed"]), self.speed) if "speed" in table else None
        slopes = {f"road.{n}": np.tile(np.interp(place, gone, table[n]), self.laps) for n in _SLOPES if n in table}
        return Way(
            np.tile(curvature(place), self.laps),
            np.full(count, self.speed) if limit is None else np.tile(limit, self.laps),
            np.full(count, self.lateral_acceleration),
            slopes,
            ((0.0, self.wait),) if self.wait > 0.0 else (),
        )


def _read(file: str, wanted: str) -> dict[str, np.ndarray]:
    if not file:
        raise ParameterError("a course from a table needs its CSV file; give it as 'file'")
    _, table = read_table(file)
    if not any(name in table for name in wanted.split(" or ")):
        raise ParameterError(f"{file}: there is no column {wanted}; add one")
    return table


def _line(table: dict[str, np.ndarray], file: str) -> tuple[np.ndarray, Curve]:
    """Distance of every row [m], and curvature as a function of distance [1/m]."""
    if "distance" in table:
        if "curvature" not in table:
            raise ParameterError(f"{file}: there is no column curvature beside distance; add it")
        gone = table["distance"] - table["distance"][0]
        return gone, lambda place: np.interp(place, gone, table["curvature"])
    if "y" not in table:
        raise ParameterError(f"{file}: there is no column y beside x; add it")
    if not np.hypot(np.diff(table["x"]), np.diff(table["y"])).all():
        raise ParameterError(f"{file}: two points in a row are the same; leave one out")
    return _through(table["x"], table["y"])


def _through(forward: np.ndarray, left: np.ndarray) -> tuple[np.ndarray, Curve]:
    from scipy.interpolate import CubicSpline

    points = np.column_stack([forward, left])
    chord = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    closed = math.hypot(*(points[-1] - points[0])) < 1e-6 * chord[-1]
    if closed:
        points[-1] = points[0]
    spline = CubicSpline(chord, points, bc_type="periodic" if closed else "natural")
    # The parameter of the spline is the chord length, so the arc length is integrated on a fine grid.
    fine = np.linspace(0.0, chord[-1], 20 * len(chord) + 1)
    first, second = spline(fine, 1), spline(fine, 2)
    length = np.hypot(*first.T)
    gone = np.concatenate([[0.0], np.cumsum(0.5 * (length[1:] + length[:-1]) * np.diff(fine))])
    bent = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / length**3
    return np.interp(chord, fine, gone), lambda place: np.interp(place, gone, bent)


AnyCourse = (
    Circuit
    | DrawnRound
    | NaturalDrive
    | StraightLane
    | Slalom
    | DoubleLaneChange
    | SteadyCircle
    | SteadyAngle
    | AngleRamp
    | StepSteer
    | SineSteer
    | RandomSteer
    | LockToLock
    | BenchSweep
    | BenchRamps
    | BenchSteps
    | BenchMultisine
    | BenchHands
    | TimeTable
    | WayTable
)
"""Union of all kinds of courses; in TOML the key `kind` selects one: "steady-circle"."""


def shipped() -> tuple[str, ...]:
    """Names of the courses that tierod ships."""
    return tuple(sorted(_data()))


def load(name: str | Path) -> AnyCourse:
    """A course, from its name or from a TOML or CSV file."""
    path = find(name)
    if path.suffix.lower() != ".csv":
        return from_document(Document.read(path, "course"))
    description, table = read_table(path)
    kind: type[TimeTable | WayTable] = TimeTable if "time" in table else WayTable
    return kind(name=path.stem, description=description, file=str(path))


def find(name: str | Path) -> Path:
    """Path of a course's file, which need not exist."""
    known = _data()
    path = known.get(str(name)) or expanded(name)
    if path.suffix.lower() not in (".toml", ".csv"):
        raise ParameterError(
            f"there is no course '{name}'{nearest(str(name), known)} A file's path ends in .toml or .csv."
        )
    return path


def from_document(document: Document) -> AnyCourse:
    """The course of a TOML document; relative file names in it start at the document's folder."""
    table = dict(document.content)
    if isinstance(table.get("file"), str):
        table["file"] = str(document.path.parent / table["file"])
    course: AnyCourse = build(AnyCourse, table, document)
    return course if course.name else replace(course, name=document.path.stem)


def _data() -> dict[str, Path]:
    return {path.stem: path for path in (Path(__file__).parent / "data").glob("*.toml")}
