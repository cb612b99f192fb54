"""Files of virtual cars: kind, parts and true parameters with their sources; monitors never read them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from tierod import vehicles
from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import numbers
from tierod.core.files import expanded
from tierod.core.toml import Document, build, flat, override
from tierod_lab.ground.cars.kinds import car_of, on_tyres, with_parts
from tierod_lab.ground.parts import Plant

SHIPPED = Path(__file__).parent
"""Folder of the virtual cars that tierod ships."""


class Sourced(NamedTuple):
    """Value of a parameter and its source."""

    value: Any
    source: str


@dataclass(frozen=True)
class CarFile:
    """Content of a virtual car's file.

    Args:
        vehicle: vehicle file with which monitors judge the car; the one of the same name, if it exists, where empty
        tyres: kind of the tyres; those of the kind of car where empty
        parameters: nested tables; each entry is a value, or a table of `value` and `source`
    """

    name: str
    description: str
    source: str
    kind: str
    good_for: tuple[str, ...]
    not_good_for: tuple[str, ...]
    vehicle: str = ""
    tyres: str = ""
    parts: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Choice:
    """Changes of a car compared with its file.

    Args:
        tyres: kind of the tyres; those of the car where empty
    """

    tyres: str = ""
    parts: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class VirtualCar:
    """A car of the virtual proving ground."""

    file: CarFile
    document: Document
    block: Plant

    @property
    def name(self) -> str:
        """Name of the car in scenarios."""
        return self.file.name

    @property
    def vehicle(self) -> str:
        """Name of the vehicle file with which monitors judge the car; "" if tierod ships none."""
        return self.file.vehicle or (self.name if self.name in vehicles.shipped() else "")

    def source_of(self, path: str) -> str:
        """Source of the value of a parameter; "" if the file does not set it."""
        given = _sourced(self.file.parameters).get(path)
        return "" if given is None else given.source

    def varied(self, choice: Choice, document: Document, location: tuple[str | int, ...] = ()) -> Plant:
        """The car with other tyres, parts and parameters, as a block.

        Values in the car's file for a part that is replaced also apply to the new part, as far as it has the same
        parameters.

        Raises:
            ParameterError: unknown tyres, parts or parameters, a wrong unit or value
        """
        block = with_parts(self.block, by_path(choice.parts), document, (*location, "parts"))
        if choice.parts:
            known = numbers(block)
            kept = {path: value for path, (value, _) in _sourced(self.file.parameters).items() if path in known}
            block = override(block, kept, self.document, ("parameters",))
        if choice.tyres:
            block = on_tyres(block, choice.tyres, document, (*location, "tyres"))
        varied: Plant = override(block, choice.parameters, document, (*location, "parameters"), self.name)
        return varied


def shipped() -> tuple[str, ...]:
    """The names of the virtual cars that tierod ships, in alphabetical order."""
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.toml")))


def find(given: str, beside: Path | None = None) -> Path:
    """Path of a virtual car's file.

    Args:
        beside: folder of relative paths; the working directory if None

    Raises:
        ParameterError: there is no such car
    """
    if given in shipped():
        return SHIPPED / f"{given}.toml"
    path = (beside or Path()) / expanded(given)
    if path.exists() and not path.is_dir():
        return path
    if path.suffix == ".toml" or Path(given).parent != Path():
        raise ParameterError(f"there is no file {path} of a virtual car; shipped ones: {', '.join(shipped())}")
    raise ParameterError(f"no virtual car is called '{given}'{nearest(given, shipped())} A file is named by its path")


def load(name_or_path: str | Path, beside: Path | None = None) -> VirtualCar:
    """The virtual car of a shipped name or of a file.

    Args:
        beside: folder of relative paths; the working directory if None

    Raises:
        ParameterError: no such car, or an invalid file; the message contains the line and the nearest names
    """
    document = Document.read(find(str(name_or_path), beside), "virtual car")
    file = build(CarFile, document.content, document)
    return VirtualCar(file, document, _block(file, document))


def by_path(table: Mapping[str, Any]) -> dict[str, Any]:
    """Values of nested tables by dotted path; a table with `value` or `kind` is a value."""
    return dict(flat(table, {"value", "kind"}))


def _sourced(parameters: Mapping[str, Any]) -> dict[str, Sourced]:
    return {
        path: Sourced(given["value"], str(given.get("source", "")))
        if isinstance(given, Mapping) and "value" in given
        else Sourced(given, "")
        for path, given in by_path(parameters).items()
    }


def _block(file: CarFile, document: Document) -> Plant:
    block = with_parts(car_of(file.kind, document), by_path(file.parts), document)
    if file.tyres:
        block = on_tyres(block, file.tyres, document, ("tyres",))
    values = {path: each.value for path, each in _sourced(file.parameters).items()}
    car: Plant = override(block, values, document, ("parameters",), file.name)
    return car
