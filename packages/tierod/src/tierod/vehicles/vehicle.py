"""A vehicle: parameters in SI units, each with standard deviation and source."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from tierod.core.errors import ParameterError, nearest
from tierod.core.screen import Screen

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
