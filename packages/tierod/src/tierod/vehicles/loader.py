"""Reading of vehicle files: check and conversion to SI units."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.plugins import FileRegistry
from tierod.core.toml_document import line_of
from tierod.core.units import COUNT, Scale, scale
from tierod.core.user_files import read_text, toml
from tierod.vehicles.catalogue import QUANTITIES, Quantity
from tierod.vehicles.vehicle import SHIPPED, Parameter, Vehicle

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError

    from tierod.vehicles.schema import ParameterEntry, VehicleFile


VEHICLES = FileRegistry("tierod.vehicles", "vehicle", SHIPPED)
"""Vehicle files shipped with tierod, and those of installed packages."""


def shipped() -> tuple[str, ...]:
    """Names of the vehicles shipped with tierod, in alphabetical order."""
    return tuple(VEHICLES.own)


def load(name_or_path: str | Path) -> Vehicle:
    """Load a vehicle by its name or from a file.

    Args:
        name_or_path: name in `VEHICLES`, or path of a vehicle file (.toml)

    Raises:
        ParameterError: the vehicle does not exist or its file is invalid; the message names the line and nearest names
    """
    path = VEHICLES.find(str(name_or_path))
    text = read_text(path, "the vehicle file", ParameterError, "give a TOML file")
    content = toml(text, path, ParameterError, "'tierod vehicles midsize-eps --toml' prints a whole one")
    return _Reader(path, text).vehicle(content)


class _Reader:
    """Reader of one vehicle file, with its text for error messages that name a line."""

    def __init__(self, path: Path, text: str):
        self.path = path
        self.text = text

    def error(self, location: Sequence[str], message: str) -> ParameterError:
        line = line_of(self.text, location)
        return ParameterError(f"{self.path}{'' if line is None else f', line {line}'}: {message}")

    def vehicle(self, content: dict[str, Any]) -> Vehicle:
        file = self.validated(content)
        parameters = {name: self.parameter(name, entry, file.torque_unit) for name, entry in file.parameters.items()}
        return Vehicle(
            name=file.name,
            description=file.description,
            source=file.source,
            good_for=tuple(file.good_for),
            not_good_for=tuple(file.not_good_for),
            torque_unit=file.torque_unit,
            parameters=parameters,
            path=self.path,
            channel_map=self.beside("map", file.channels.map),
            database=self.beside("dbc", file.channels.dbc),
            thresholds=file.thresholds,
            monitor=file.monitor,
        )

    def validated(self, content: dict[str, Any]) -> VehicleFile:
        from pydantic import ValidationError

        from tierod.vehicles.schema import VehicleFile

        given = content.get("parameters")
        for name in given if isinstance(given, dict) else ():
            if name not in QUANTITIES:
                raise self.error(("parameters", name), f"no parameter is called '{name}'{nearest(name, QUANTITIES)}")
        try:
            return VehicleFile.model_validate(content)
        except ValidationError as error:
            raise self.explained(error) from None

    def explained(self, error: ValidationError) -> ParameterError:
        from tierod.vehicles.schema import ChannelsEntry, ParameterEntry, VehicleFile

        # A misspelt key causes an unknown and a missing key; the unknown one is more helpful.
        first = min(error.errors(), key=lambda slip: slip["type"] != "extra_forbidden")
        location = [str(part) for part in first["loc"]]
        key = ".".join(location)
        more = "" if error.error_count() == 1 else f" (this is the first of {error.error_count()} errors in the file)"
        if first["type"] == "extra_forbidden":
            owners: tuple[type[BaseModel], ...] = (VehicleFile, ChannelsEntry, ParameterEntry)
            owner = owners[len(location) - 1]
            return self.error(
                location, f"'{location[-1]}' is not known here{nearest(location[-1], owner.model_fields)}{more}"
            )
        if first["type"] == "missing":
            return self.error(location, f"'{key}' is missing; add it{more}")
        given = repr(first["input"])
        return self.error(location, f"'{key}' is {given[:60]}: {first['msg'][0].lower()}{first['msg'][1:]}{more}")

    def parameter(self, name: str, entry: ParameterEntry, torque_unit: str) -> Parameter:
        quantity = QUANTITIES[name]
        unit = torque_unit if quantity.torque else quantity.unit
        try:
            to_si = Scale(1.0) if entry.unit == unit else scale(entry.unit, unit)
        except InputError as error:
            raise self.error(("parameters", name, "unit"), f"{name}: {error}") from None
        value = to_si(entry.value)
        self.check(quantity, value, unit)
        spread = None if entry.standard_deviation is None else entry.standard_deviation * to_si.factor
        # Older files of 'tierod new' state a spread of whole numbers, too.
        spread = 0.0 if quantity.whole else spread
        return Parameter(name, value, unit, spread, entry.source)

    def check(self, quantity: Quantity, value: float, unit: str) -> None:
        low, high = quantity.plausible
        # Plausible ranges hold for SI units; raw counts have an unknown scale.
        if unit != COUNT and not low <= value <= high:
            raise self.error(
                ("parameters", quantity.name, "value"),
                f"{quantity.name} is {f'{value:g} {unit}'.strip()}, but a road vehicle lies between "
                f"{low:g} and {f'{high:g} {unit}'.strip()}; "
                "check the value and its unit",
            )
        if quantity.whole and not value.is_integer():
            raise self.error(
                ("parameters", quantity.name, "value"), f"{quantity.name} is {value:g}, but it is a whole number"
            )

    def beside(self, key: str, name: str | None) -> Path | None:
        """Path of a file named in the vehicle file: in its folder, or a shipped file of that name."""
        if name is None:
            return None
        # A vehicle file written with a path and then moved has the named file in its own folder.
        places = (self.path.parent / name, self.path.parent / Path(name).name, SHIPPED / Path(name).name)
        found = next((path for path in places if path.is_file()), None)
        if found is None:
            raise self.error(
                ("channels", key),
                f"the file {places[0]} is not there, and tierod ships none of its name; put it beside the vehicle "
                "file, correct the name, or leave the key out",
            )
        return found
