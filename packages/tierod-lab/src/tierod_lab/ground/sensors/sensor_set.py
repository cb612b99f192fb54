"""Sets of sensors: the measured channels of a car."""

from __future__ import annotations

from collections.abc import ItemsView, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.signals import SIGNALS, signal
from tierod.core.toml import Document, Location, build
from tierod_lab.ground.sensors.sensor import Sensor

PRESETS = ("production", "ideal", "bench", "worn")
"""Names of the shipped sets of sensors."""


@dataclass(frozen=True)
class SensorSet:
    """The sensors of a car by canonical signal; sensors of signals that a car lacks have no effect.

    Raises:
        ParameterError: a name that is not a canonical signal
    """

    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    description: str = ""

    def __post_init__(self) -> None:
        for name in self.sensors:
            if name not in SIGNALS:
                raise ParameterError(f"a sensor cannot measure '{name}'{nearest(name, SIGNALS)}")

    def items(self) -> ItemsView[str, Sensor]:
        return self.sensors.items()

    def __contains__(self, name: str) -> bool:
        return name in self.sensors

    def __getitem__(self, name: str) -> Sensor:
        if name not in self.sensors:
            raise ParameterError(f"no sensor measures '{name}'{nearest(name, self.sensors)}")
        return self.sensors[name]

    def with_sensors(self, sensors: Mapping[str, Sensor]) -> SensorSet:
        """The set with sensors added or replaced."""
        return replace(self, sensors={**self.sensors, **sensors})

    def without(self, names: Iterable[str]) -> SensorSet:
        """The set without these channels."""
        left_out = {name: self[name] for name in names}
        return replace(self, sensors={name: each for name, each in self.items() if name not in left_out})

    def only(self, names: Iterable[str]) -> SensorSet:
        """The set with these channels only."""
        return replace(self, sensors={name: self[name] for name in names})

    def at_rate(self, rate: float) -> SensorSet:
        """The set with all sensors at one rate [Hz]."""
        return replace(self, sensors={name: replace(each, rate=rate) for name, each in self.items()})

    @classmethod
    def production(cls) -> SensorSet:
        """Sensors of a production car, as on its bus."""
        return _shipped("production")

    @classmethod
    def bench(cls) -> SensorSet:
        """Sensors of a test bench or a well equipped test car."""
        return _shipped("bench")

    @classmethod
    def worn(cls) -> SensorSet:
        """Sensors of a production car after long use, on a busy bus."""
        return _shipped("worn")

    @classmethod
    def ideal(cls, rate: float = 100.0) -> SensorSet:
        """Sensors without errors of all canonical signals, at this rate [Hz]."""
        return cls(dict.fromkeys(SIGNALS, Sensor(rate=rate)), "Every signal as it is.")

    @classmethod
    def preset(cls, name: str) -> SensorSet:
        """The shipped set of this name.

        Raises:
            ParameterError: no set has this name
        """
        if name not in PRESETS:
            raise ParameterError(f"no set of sensors is called '{name}'{nearest(name, PRESETS)}")
        return cls.ideal() if name == "ideal" else _shipped(name)

    @classmethod
    def from_table(
        cls, table: Mapping[str, Any], document: Document, location: Location = (), base: SensorSet | None = None
    ) -> SensorSet:
        """The set of a table.

        Args:
            table: `preset` (a shipped name, or a file beside the document), `rate` of all, `without` (names), and one
                table per channel with changes of the preset; a channel that the preset lacks is added
            base: set to start from where the table names no preset; "production" if None

        Raises:
            ParameterError: an invalid entry, with file and line
        """
        own = ("preset", "rate", "without", "description")
        start = _start(table, document, location, base)
        if "rate" in table:
            rate = {"rate": table["rate"]}
            start = start.at_rate(build(Sensor, rate, document, location).rate)
        for number, name in enumerate(_names(table, document, location)):
            if name not in start:
                raise document.error(
                    (*location, "without", number), f"no sensor measures '{name}'{nearest(name, start.sensors)}"
                )
        start = start.without(table.get("without", ()))
        changed = {}
        for name, given in table.items():
            if name in own:
                continue
            place = (*location, name)
            try:
                unit = signal(name).unit
            except InputError:
                known = [*own, *SIGNALS]
                raise document.error(place, f"a sensor cannot measure '{name}'{nearest(name, known)}") from None
            changed[name] = build(Sensor, given, document, place, base=start.sensors.get(name), signal=unit)
        description = table.get("description", start.description)
        if not isinstance(description, str):
            raise document.error((*location, "description"), "'description' has to be a text")
        return replace(start.with_sensors(changed), description=description)


def _start(table: Mapping[str, Any], document: Document, location: Location, base: SensorSet | None) -> SensorSet:
    if "preset" not in table:
        return SensorSet.production() if base is None else base
    name = table["preset"]
    if name in PRESETS:
        return SensorSet.preset(name)
    path = document.path.parent / str(name)
    if not (str(name).endswith(".toml") and path.is_file()):
        known = f"{nearest(str(name), PRESETS)} A file of your own is named by its path"
        raise document.error((*location, "preset"), f"no set of sensors is called '{name}'{known}")
    try:
        file = document.beside(path.absolute(), "sensor")
    except ParameterError as error:
        raise document.error((*location, "preset"), str(error)) from None
    return SensorSet.from_table(file.content, file)


def _names(table: Mapping[str, Any], document: Document, location: Location) -> list[str]:
    names = table.get("without", [])
    if not (isinstance(names, list) and all(isinstance(name, str) for name in names)):
        raise document.error((*location, "without"), "'without' has to be a list of names")
    return names


@cache
def _shipped(name: str) -> SensorSet:
    document = Document.read(Path(__file__).with_name(f"{name}.toml"), "sensor")
    return SensorSet.from_table(document.content, document, base=SensorSet())
