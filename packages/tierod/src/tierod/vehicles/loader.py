"""Reading of vehicle files: check and conversion to SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE, Range
from tierod.core.plugins import FileRegistry
from tierod.core.toml import Document, build
from tierod.core.units import COUNT, Scale, scale
from tierod.core.user_files import read_text, toml
from tierod.vehicles.catalogue import QUANTITIES, Quantity
from tierod.vehicles.vehicle import SHIPPED, Parameter, Vehicle

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
