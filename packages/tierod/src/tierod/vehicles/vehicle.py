"""A vehicle: parameters in SI units, each with standard deviation and source."""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias, TypeVar

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE, Range
from tierod.core.plugins import FileRegistry
from tierod.core.shown import Screen
from tierod.core.toml import Document, build
from tierod.core.units import COUNT, Scale, scale
from tierod.core.user_files import read_text, toml

if TYPE_CHECKING:
    from tierod.io.readers.channel_map import ChannelMap
    from tierod.io.readers.opening import Paths

Parameters = TypeVar("Parameters")

SHIPPED = Path(__file__).parent  # Folder of the vehicle files shipped with tierod


@dataclass(frozen=True)
class Parameter:
    name: str
    value: float
    unit: str  # SI, in the notation of pint; "count" for a torque of an uncalibrated vehicle
    standard_deviation: float | None  # one sigma in the unit; None if unknown
    source: str  # origin of the value; begins with "assumed" if it was not measured

    @property
    def assumed(self) -> bool:
        """Whether the value is assumed rather than measured on this vehicle."""
        return self.source.lower().startswith("assumed")


@dataclass(frozen=True)
class Vehicle:
    """Parameter set of a car, real or from a paper."""

    name: str  # short, as given on the command line
    description: str
    source: str  # origin of the set as a whole
    good_for: tuple[str, ...]  # good_for, not_good_for: uses for which the set is and is not suitable
    not_good_for: tuple[str, ...]
    torque_unit: str  # "N*m", or "count" if torques in its recordings are raw
    parameters: Mapping[str, Parameter]  # by name, in SI units
    path: Path  # the file it was read from
    # channel_map, database: files that define how its recordings are read; None without one
    channel_map: Path | None = None
    database: Path | None = None
    # from a calibration on fault-free drives, by kind; each a text, a number or numbers by name, checked by the monitor
    # that uses them
    thresholds: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    monitor: str | None = None  # default monitor for its recordings; None for the choice of tierod

    @property
    def calibrated(self) -> bool:
        """Whether torques in this vehicle's recordings are in newton metres."""
        return self.torque_unit != "count"

    @property
    def facts(self) -> list[tuple[str, str]]:
        return [("vehicle", self.name), ("described as", self.description), ("source", self.source)]

    def __contains__(self, name: object) -> bool:
        return name in self.parameters

    def __getitem__(self, name: str) -> float:
        if name in self.parameters:
            return self.parameters[name].value
        raise ParameterError(
            f"the vehicle '{self.name}' has no parameter '{name}'{nearest(name, self.parameters)} "
            f"{self._adding([name])}"
        )

    def parameters_for(self, wanted: type[Parameters]) -> Parameters:
        """An instance of a parameter dataclass, filled from the parameters with the names of its fields."""
        fields = [field for field in dataclasses.fields(wanted) if field.init]  # type: ignore[arg-type]
        absent = [f.name for f in fields if f.name not in self.parameters and _has_no_default(f)]
        if absent:
            raise ParameterError(f"the vehicle '{self.name}' lacks {', '.join(absent)}. {self._adding(absent)}")
        return wanted(**{f.name: self.parameters[f.name].value for f in fields if f.name in self.parameters})

    def _adding(self, names: list[str]) -> str:
        """Advice on how to add parameters: to the user's own file, or to a copy of a shipped one."""
        tables = " and ".join(f"[parameters.{name}]" for name in names)
        if self.path.parent != SHIPPED:
            return f"Add {tables} to {self.path}"
        own = f"tierod vehicles {self.name} --toml > car.toml"
        return f"Begin a vehicle file of your own ({own}), add {tables} to it, and give --vehicle car.toml"

    def screen(self) -> Screen:
        """Display of the vehicle in a terminal or a notebook."""
        lines = (self.description, *(f"good for {each}" for each in self.good_for))
        rows = [
            (p.name, f"{p.value:.6g}", "" if p.standard_deviation is None else f"{p.standard_deviation:.6g}", p.unit)
            for p in self.parameters.values()
        ]
        return Screen(f"Vehicle {self.name}", lines, ("parameter", "value", "±", "unit"), rows)

    def __repr__(self) -> str:
        return self.screen().text()

    def _repr_html_(self) -> str:
        return self.screen().html()

    def rows(self) -> tuple[tuple[str, float, str, float | None, str], ...]:
        return tuple((p.name, p.value, p.unit, p.standard_deviation, p.source) for p in self.parameters.values())


def _has_no_default(field: dataclasses.Field[Any]) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


@dataclass(frozen=True)
class Quantity:
    """One parameter of a vehicle file."""

    name: str  # of the field in parameter dataclasses
    unit: str  # SI, in the notation of pint; "" for a dimensionless number
    meaning: str  # one sentence fragment, with the point of reference
    # smallest and largest value of a real vehicle, in the unit; others indicate a wrong unit
    plausible: tuple[float, float]
    torque: bool = False  # whether it is a steering torque, which an uncalibrated car gives in counts
    whole: bool = False  # whether it is a whole number, which has no spread


def _catalogue() -> Iterator[Quantity]:
    with Path(__file__).with_name("quantities.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            plausible, kind = (float(row["low"]), float(row["high"])), row["kind"]
            yield Quantity(row["name"], row["unit"], row["meaning"], plausible, kind == "torque", kind == "whole")


QUANTITIES = {quantity.name: quantity for quantity in _catalogue()}  # All parameters of a vehicle file, by name


# Vehicle files shipped with tierod, and those of installed packages
VEHICLES = FileRegistry("tierod.vehicles", "vehicle", SHIPPED)


class _Filled(Range):
    def holds(self, value: object) -> bool:
        return bool(str(value).strip())

    def __str__(self) -> str:
        return "a text that is not empty"


Text = Annotated[str, _Filled()]
Threshold = float | str | Mapping[str, float]  # A number, a text on its origin, or numbers by name


@dataclass(frozen=True)
class ParameterEntry:
    """One `[parameters.NAME]` table, in the unit that it names."""

    value: float
    unit: str
    source: Text
    standard_deviation: Annotated[float, "", NOT_NEGATIVE] | None = None


@dataclass(frozen=True)
class ChannelsEntry:
    """The `[channels]` table: files that define how recordings of the vehicle are read."""

    map: Text | None = None
    dbc: Text | None = None


@dataclass(frozen=True)
class VehicleFile:
    name: Text
    description: Text
    source: Text
    good_for: tuple[Text, ...]
    not_good_for: tuple[Text, ...]
    torque_unit: Literal["N*m", "count"]
    parameters: Mapping[str, ParameterEntry]
    monitor: Text | None = None
    channels: ChannelsEntry = field(default_factory=ChannelsEntry)
    thresholds: Mapping[str, Mapping[str, Threshold]] = field(default_factory=dict)


def shipped() -> tuple[str, ...]:
    """Names of the vehicles shipped with tierod, in alphabetical order."""
    return tuple(VEHICLES.own)


def load(name_or_path: str | Path) -> Vehicle:
    """Load a vehicle by its name or from a file."""
    path = VEHICLES.find(str(name_or_path))
    text = read_text(path, "the vehicle file", ParameterError, "give a TOML file")
    content = toml(text, path, ParameterError, "'tierod vehicles midsize-eps --toml' prints a whole one")
    document = Document(content, text, path)
    given = content.get("parameters")
    for name in given if isinstance(given, dict) else ():
        if name not in QUANTITIES:
            raise document.error(("parameters", name), f"no parameter is called '{name}'{nearest(name, QUANTITIES)}")
    file: VehicleFile = build(VehicleFile, content, document)
    for key in ("good_for", "not_good_for"):
        if not getattr(file, key):
            raise document.error((key,), f"'{key}' is empty; give at least one use")
    return Vehicle(
        name=file.name,
        description=file.description,
        source=file.source,
        good_for=file.good_for,
        not_good_for=file.not_good_for,
        torque_unit=file.torque_unit,
        parameters={name: _parameter(name, each, file.torque_unit, document) for name, each in file.parameters.items()},
        path=path,
        channel_map=_beside("map", file.channels.map, document),
        database=_beside("dbc", file.channels.dbc, document),
        thresholds=file.thresholds,
        monitor=file.monitor,
    )


def _parameter(name: str, entry: ParameterEntry, torque_unit: str, document: Document) -> Parameter:
    quantity = QUANTITIES[name]
    unit = torque_unit if quantity.torque else quantity.unit
    try:
        to_si = Scale(1.0) if entry.unit == unit else scale(entry.unit, unit)
    except InputError as error:
        raise document.error(("parameters", name, "unit"), f"{name}: {error}") from None
    value = to_si(entry.value)
    _check(quantity, value, unit, document)
    spread = None if entry.standard_deviation is None else entry.standard_deviation * to_si.factor
    # Older files of 'tierod new' state a spread of whole numbers, too.
    return Parameter(name, value, unit, 0.0 if quantity.whole else spread, entry.source)


def _check(quantity: Quantity, value: float, unit: str, document: Document) -> None:
    low, high = quantity.plausible
    place = ("parameters", quantity.name, "value")
    # Plausible ranges hold for SI units; raw counts have an unknown scale.
    if unit != COUNT and not low <= value <= high:
        raise document.error(
            place,
            f"{quantity.name} is {f'{value:g} {unit}'.strip()}, but a road vehicle lies between {low:g} and "
            f"{f'{high:g} {unit}'.strip()}; check the value and its unit",
        )
    if quantity.whole and not value.is_integer():
        raise document.error(place, f"{quantity.name} is {value:g}, but it is a whole number")


def _beside(key: str, name: str | None, document: Document) -> Path | None:
    if name is None:
        return None
    # A vehicle file written with a path and then moved has the named file in its own folder.
    places = (document.path.parent / name, document.path.parent / Path(name).name, SHIPPED / Path(name).name)
    found = next((path for path in places if path.is_file()), None)
    if found is None:
        raise document.error(
            ("channels", key),
            f"the file {places[0]} is not there, and tierod ships none of its name; put it beside the vehicle "
            "file, correct the name, or leave the key out",
        )
    return found


Map: TypeAlias = "str | Path | ChannelMap | None"


def read_by(vehicle: Vehicle | None, dbc: Paths = None, channel_map: Map = None) -> tuple[tuple[str | Path, ...], Map]:
    """CAN databases and channel map for recordings of a vehicle: the given ones, else its own."""
    databases = dbc or (vehicle.database if vehicle else None) or ()
    paths = (databases,) if isinstance(databases, str | Path) else tuple(databases)
    return paths, channel_map or (vehicle.channel_map if vehicle else None)
