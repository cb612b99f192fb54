"""Virtual cars as files: kind, parts and parameters of the truth, each with its source; never those of a monitor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from tierod import vehicles
from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import numbers
from tierod.core.files import expanded
from tierod.core.toml import Document, build, override
from tierod.proving_ground.cars.kinds import car_of, on_tyres, with_parts
from tierod.proving_ground.parts import Plant

SHIPPED = Path(__file__).parent
"""Where the files of the virtual cars are that tierod ships."""


class Sourced(NamedTuple):
    """A value, and where it comes from."""

    value: Any
    source: str


@dataclass(frozen=True)
class CarFile:
    """A file of a virtual car as a whole.

    Args:
        name, description: as lists show them
        source: where the set as a whole comes from
        kind: of car
        good_for, not_good_for: what may and may not be concluded with it
        vehicle: file with which monitors judge it; that of its own name where empty and there is one
        tyres: by name; those of the kind where empty
        parts: of other kinds than usual, by dotted path
        parameters: nested tables; each a value, or a table of `value` and `source`
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
    """Differences of a car from its file.

    Args:
        tyres: by name; its own where empty
        parts: nested tables of names
        parameters: nested tables, or values by dotted path
    """

    tyres: str = ""
    parts: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class VirtualCar:
    """A car of the virtual proving ground.

    Args:
        file: content of its file
        document: the file
        block: the car itself
    """

    file: CarFile
    document: Document
    block: Plant

    @property
    def name(self) -> str:
        """Name of the car in scenarios."""
        return self.file.name

    @property
    def vehicle(self) -> str:
        """Name of the vehicle file with which monitors judge it; "" where tierod ships none."""
        return self.file.vehicle or (self.name if self.name in vehicles.shipped() else "")

    def source_of(self, path: str) -> str:
        """Source of the value of a parameter; "" for what the file does not set."""
        given = _sourced(self.file.parameters).get(path)
        return "" if given is None else given.source

    def varied(self, choice: Choice, document: Document, location: tuple[str | int, ...] = ()) -> Plant:
        """The car with other tyres, parts and parameters, as a block.

        Values in the car's file for a part that is replaced apply to the new one as far as it has the same
        parameters.

        Args:
            choice: what differs
            document: where it stands
            location: of its table in the document

        Raises:
            ParameterError: unknown tyres, parts or parameters, a wrong unit or value
        """
        block = with_parts(self.block, flat(choice.parts), document, (*location, "parts"))
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
    """The file of a virtual car.

    Args:
        given: a name that `shipped` lists, or a path
        beside: folder from which a relative path counts; the working directory where None

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
        name_or_path: a name that `shipped` lists, or the path of a file (.toml)
        beside: folder from which a relative path counts; the working directory where None

    Raises:
        ParameterError: no such car, or a file with a slip in it; the message names the line and the nearest names
    """
    document = Document.read(find(str(name_or_path), beside), "virtual car")
    file = build(CarFile, document.content, document)
    return VirtualCar(file, document, _block(file, document))


def flat(table: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Values by dotted path of nested tables; a table with `value` or `kind` is a value."""
    found: dict[str, Any] = {}
    for name, value in table.items():
        if isinstance(value, Mapping) and not {"value", "kind"} & set(value):
            found |= flat(value, f"{above}{name}.")
        else:
            found[f"{above}{name}"] = value
    return found


def _sourced(parameters: Mapping[str, Any]) -> dict[str, Sourced]:
    return {
        path: Sourced(given["value"], str(given.get("source", "")))
        if isinstance(given, Mapping) and "value" in given
        else Sourced(given, "")
        for path, given in flat(parameters).items()
    }


def _block(file: CarFile, document: Document) -> Plant:
    """The block that a file describes."""
    block = with_parts(car_of(file.kind, document), flat(file.parts), document)
    if file.tyres:
        block = on_tyres(block, file.tyres, document, ("tyres",))
    values = {path: each.value for path, each in _sourced(file.parameters).items()}
    car: Plant = override(block, values, document, ("parameters",), file.name)
    return car
