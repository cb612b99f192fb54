"""The courses that are shipped, and those in files of one's own."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from pathlib import Path

from tierod.core.errors import ParameterError, nearest
from tierod.core.files import expanded
from tierod.core.toml import Document, build
from tierod.proving_ground.courses.bench import BenchHands, BenchMultisine, BenchRamps, BenchSteps, BenchSweep
from tierod.proving_ground.courses.circuit import Circuit, DrawnRound
from tierod.proving_ground.courses.lane import DoubleLaneChange, Slalom, SteadyCircle, StraightLane
from tierod.proving_ground.courses.natural import NaturalDrive
from tierod.proving_ground.courses.open_loop import (
    AngleRamp,
    LockToLock,
    RandomSteer,
    SineSteer,
    SteadyAngle,
    StepSteer,
)
from tierod.proving_ground.courses.table import TimeTable, WayTable, read_table

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
"""Every kind of course; in TOML the key `kind` names one: "steady-circle"."""


def shipped() -> tuple[str, ...]:
    """Names of the courses that are shipped."""
    return tuple(sorted(_data()))


def described(name: str) -> str:
    """Description of a shipped course, in one sentence.

    Raises:
        ParameterError: there is no course of this name; the nearest are named
    """
    return load(name).description


def load(name: str | Path) -> AnyCourse:
    """A course, from its name or from a TOML or CSV file.

    Args:
        name: of a shipped course, or the path of a file

    Raises:
        ParameterError: there is none, or what it says is wrong; with file, line and nearest name
    """
    path = find(name)
    return _from_table(path) if path.suffix.lower() == ".csv" else from_document(Document.read(path, "course"))


def find(name: str | Path) -> Path:
    """The file of a course; arguments and errors as of `load`, but it need not exist."""
    known = _data()
    path = known.get(str(name)) or expanded(name)
    if path.suffix.lower() not in (".toml", ".csv"):
        raise ParameterError(
            f"there is no course '{name}'{nearest(str(name), known)} A file's path ends in .toml or .csv."
        )
    return path


def from_document(document: Document) -> AnyCourse:
    """The course that a TOML document describes; its file names count from the document's folder."""
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
    folder = files("tierod.proving_ground.courses") / "data"
    return {Path(each.name).stem: Path(str(each)) for each in folder.iterdir() if each.name.endswith(".toml")}
