"""Cars by name, and the kinds that scenarios and files may name."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path
from typing import Any, get_args

from tierod import vehicles
from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import hints, meaning, members, numbers, replaced
from tierod.core.files import expanded
from tierod.core.toml import build, flat, kind_name, override
from tierod.core.toml_document import Document, Location
from tierod_lab.ground.cars.benches import ColumnBench, MotorBench
from tierod_lab.ground.cars.road_cars import ActiveFrontCar, DemonstratorCar, EpsCar, PmEpsCar, SteerByWireCar
from tierod_lab.ground.chassis import TYRES, SingleTrack, TwoTrack
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.steering.column_eps import ColumnEps
from tierod_lab.ground.steering.friction import Coulomb, Dahl, DahlPower, LuGre, MaxwellSlip, Stribeck
from tierod_lab.ground.steering.rack_eps import RackEps

_CARS: tuple[type, ...] = (EpsCar, PmEpsCar, SteerByWireCar, ActiveFrontCar, DemonstratorCar, ColumnBench, MotorBench)

KINDS: dict[str, type] = {kind_name(each): each for each in _CARS}  # Classes of the cars by name

_FAMILIES: tuple[tuple[type, ...], ...] = (
    (SingleTrack, TwoTrack),
    (ColumnEps, RackEps),
    (Dahl, DahlPower, Coulomb, MaxwellSlip, Stribeck, LuGre),
)
"""Parts whose fields are declared as protocols; each can replace any other of its family."""

NONE = "none"  # Name for a part that is left out


def car_of(kind: str, document: Document) -> Plant:
    if kind not in KINDS:
        raise document.error(("kind",), f"no kind of car is called '{kind}'{nearest(kind, KINDS)}")
    car: Plant = KINDS[kind]()
    return car


def choices(block: Any, path: str = "") -> dict[str, dict[str, type | None]]:
    """Classes that can fill the exchangeable fields of a car, by dotted path and name; None leaves the part out."""
    found: dict[str, dict[str, type | None]] = {}
    kind: Any = type(block)
    for each in dataclasses.fields(block):
        part, place = getattr(block, each.name), f"{path}{each.name}"
        choice = _choice(part, hints(kind)[each.name])
        if len(choice) > 1:
            found[place] = choice
        if dataclasses.is_dataclass(part):
            found |= choices(part, f"{place}.")
    return found


def _choice(part: object, annotation: object) -> dict[str, type | None]:
    family = next((family for family in _FAMILIES if type(part) in family), ())
    if family:
        return {kind_name(each): each for each in family}
    means = meaning(annotation)
    kinds: list[Any] = [each.hint for each in members(means) if dataclasses.is_dataclass(each.hint)]
    choice: dict[str, type | None] = {kind_name(each): each for each in kinds}
    return choice | ({NONE: None} if choice and type(None) in get_args(means.hint) else {})


def parts_of(block: object) -> dict[str, str]:
    """Names of the parts in the exchangeable fields of a car, by dotted path."""
    parts = {place: attrgetter(place)(block) for place in choices(block)}
    return {place: NONE if part is None else kind_name(type(part)) for place, part in parts.items()}


def with_parts(block: Plant, parts: Mapping[str, str], document: Document, location: Location = ("parts",)) -> Plant:
    """A car with other parts, each with the defaults of its class; outer parts are replaced first."""
    # Outer parts come first, since they determine which inner parts exist.
    for place, name in sorted(parts.items(), key=lambda part: part[0].count(".")):
        known = choices(block)
        try:
            if place not in known:
                what = "no part of the car that can be chosen is called"
                raise ParameterError(f"{what} '{place}'{nearest(place, known)}")
            if name not in known[place]:
                raise ParameterError(f"no {place} is called '{name}'{nearest(str(name), known[place])}")
            kind = known[place][name]
            block = replaced(block, {place: None if kind is None else kind()})
        except ParameterError as error:
            raise document.error((*location, place), str(error)) from None
    return block


def on_tyres(block: Plant, name: str, document: Document, location: Location) -> Plant:
    """A car on tyres of another kind, in the sizes of its own tyres."""
    known = {each.replace(" ", "-"): tyre for each, tyre in TYRES.items()}
    if name not in known:
        raise document.error(location, f"no tyres are called '{name}'{nearest(name, known)}")
    chassis = getattr(block, "chassis", None)
    if not isinstance(chassis, TwoTrack):
        raise document.error(location, "this car has no tyres to choose from; take one with the chassis two-track")
    own = (chassis.front.tyre, chassis.rear.tyre)
    sized = [dataclasses.replace(known[name], radius=each.radius, nominal_load=each.nominal_load) for each in own]
    changed: Plant = replaced(block, {"chassis": chassis.on_tyres(*sized)})
    return changed


SHIPPED = Path(__file__).parent  # Folder of the virtual cars that tierod ships


@dataclass(frozen=True)
class CarFile:
    """Content of a virtual car's file."""

    name: str
    description: str
    source: str
    kind: str
    good_for: tuple[str, ...]
    not_good_for: tuple[str, ...]
    # vehicle file with which monitors judge the car; the one of the same name, if it exists, where empty
    vehicle: str = ""
    tyres: str = ""  # kind of the tyres; those of the kind of car where empty
    parts: Mapping[str, Any] = field(default_factory=dict)
    # nested tables; each entry is a value, or a table of `value` and `source`
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Choice:
    """Changes of a car compared with its file."""

    tyres: str = ""  # kind of the tyres; those of the car where empty
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
        return self.file.name

    @property
    def vehicle(self) -> str:
        return self.file.vehicle or (self.name if self.name in vehicles.shipped() else "")

    def source_of(self, path: str) -> str:
        """Source of the value of a parameter; "" if the file does not set it."""
        return _sourced(self.file.parameters).get(path, (None, ""))[1]

    def varied(self, choice: Choice, document: Document, location: tuple[str | int, ...] = ()) -> Plant:
        """The car with other tyres, parts and parameters, as a block.

        Values in the car's file for a part that is replaced also apply to the new part, as far as it has the same
        parameters.
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
    """The virtual car of a shipped name or of a file; arguments as in `find`."""
    document = Document.read(find(str(name_or_path), beside), "virtual car")
    file = build(CarFile, document.content, document)
    return VirtualCar(file, document, _block(file, document))


def by_path(table: Mapping[str, Any]) -> dict[str, Any]:
    """Values of nested tables by dotted path; a table with `value` or `kind` is a value."""
    return dict(flat(table, {"value", "kind"}))


def _sourced(parameters: Mapping[str, Any]) -> dict[str, tuple[Any, str]]:
    """(value, source) by dotted path."""
    found = {}
    for path, given in by_path(parameters).items():
        own = given if isinstance(given, Mapping) and "value" in given else {"value": given}
        found[path] = own["value"], str(own.get("source", ""))
    return found


def _block(file: CarFile, document: Document) -> Plant:
    block = with_parts(car_of(file.kind, document), by_path(file.parts), document)
    if file.tyres:
        block = on_tyres(block, file.tyres, document, ("tyres",))
    values = {path: value for path, (value, _) in _sourced(file.parameters).items()}
    car: Plant = override(block, values, document, ("parameters",), file.name)
    return car
