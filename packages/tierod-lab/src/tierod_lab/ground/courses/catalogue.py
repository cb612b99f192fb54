"""Courses that tierod ships, and courses from a user's files."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from pathlib import Path

from tierod.core.errors import ParameterError, nearest
from tierod.core.files import expanded
from tierod.core.toml import Document, build
from tierod_lab.ground.courses.bench import BenchHands, BenchMultisine, BenchRamps, BenchSteps, BenchSweep
from tierod_lab.ground.courses.circuit import Circuit, DrawnRound
from tierod_lab.ground.courses.lane import DoubleLaneChange, Slalom, SteadyCircle, StraightLane
from tierod_lab.ground.courses.natural import NaturalDrive
from tierod_lab.ground.courses.open_loop import (
    AngleRamp,
    LockToLock,
    RandomSteer,
    SineSteer,
    SteadyAngle,
    StepSteer,
)
from tierod_lab.ground.courses.table import TimeTable, WayTable, read_table

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


def described(name: str) -> str:
    """Description of a shipped course, in one sentence.

    Raises:
        ParameterError: no such course; the message contains the nearest names
    """
    return load(name).description


def load(name: str | Path) -> AnyCourse:
    """A course, from its name or from a TOML or CSV file.

    Raises:
        ParameterError: no such course, or an invalid file; with file, line and nearest name
    """
    path = find(name)
    return _from_table(path) if path.suffix.lower() == ".csv" else from_document(Document.read(path, "course"))


def find(name: str | Path) -> Path:
    """Path of a course's file, which need not exist; arguments and errors as in `load`."""
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


def _from_table(path: Path) -> AnyCourse:
    description, table = read_table(path)
    kind: type[TimeTable | WayTable] = TimeTable if "time" in table else WayTable
    return kind(name=path.stem, description=description, file=str(path))


def _data() -> dict[str, Path]:
    folder = files("tierod_lab.ground.courses") / "data"
    return {Path(each.name).stem: Path(str(each)) for each in folder.iterdir() if each.name.endswith(".toml")}
