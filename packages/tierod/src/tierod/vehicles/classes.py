"""Typical parameter values of each class of cars, and the spread of the cars within a class."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

from tierod.core.errors import ParameterError, nearest
from tierod.core.user_files import read_text, toml
from tierod.vehicles.catalogue import QUANTITIES
from tierod.vehicles.vehicle import SHIPPED, Parameter, Vehicle

FILE = SHIPPED / "classes.toml"

USUAL = "midsize"  # Class of a car with unknown mass and wheelbase


class Known(NamedTuple):
    """A value in SI units with its standard deviation; None if that is unknown."""

    value: float
    standard_deviation: float | None = None
    source: str = ""


@dataclass(frozen=True)
class Rule:
    """Rule that gives a quantity for each class of cars."""

    name: str
    unit: str
    values: Mapping[str, float]  # value by class; with powers the factor of the rule
    powers: Mapping[str, float]  # value = factor * product of quantity ** power
    relative: Mapping[str, float]  # relative standard deviation by class, of a value that is not given
    absolute: float  # further standard deviation [unit]
    given: float | None  # relative standard deviation of a value given without one; None for the same as `relative`
    source: str
    spread_alone: bool = False  # whether only the spread is usable and the value must be given

    def spread(self, value: float, of: str) -> float:
        """Standard deviation of a value that is given without one [unit]."""
        relative = self.relative[of] if self.given is None else self.given
        return math.hypot(relative * value, self.absolute)


@cache
def _content() -> dict[str, Any]:
    return toml(read_text(FILE, "the table of classes", ParameterError), FILE, ParameterError)


def classes() -> dict[str, str]:
    """Descriptions of the classes of cars, by name."""
    return dict(_content()["classes"])


def require_class(name: str) -> None:
    """Check that a class exists."""
    if name not in classes():
        raise ParameterError(f"no class of cars is called '{name}'{nearest(name, classes())}")


@cache
def rules() -> dict[str, Rule]:
    """Rules by quantity; wheelbase and front_share are no parameters of a vehicle file."""
    return {name: _rule(name, table) for name, table in _content()["quantities"].items()}


def _rule(name: str, table: Mapping[str, Any]) -> Rule:
    def by_class(key: str, default: float) -> dict[str, float]:
        given = table.get(key, default)
        return {of: float(given[of] if isinstance(given, dict) else given) for of in classes()}

    return Rule(
        name,
        str(table["unit"] if "unit" in table else QUANTITIES[name].unit),
        by_class("value", math.nan),
        table.get("powers", {}),
        by_class("relative", 0.0),
        float(table.get("absolute", 0.0)),
        table.get("given"),
        str(table["source"]),
        bool(table.get("spread_alone", False)),
    )


def class_of(vehicle: Vehicle) -> str:
    if vehicle.path.parent == SHIPPED and vehicle.name in _content()["shipped"]:
        return str(_content()["shipped"][vehicle.name])
    known = {name: vehicle[name] for name in ("mass", "tyre_friction") if name in vehicle}
    if "front_distance" in vehicle and "rear_distance" in vehicle:
        known["wheelbase"] = vehicle["front_distance"] + vehicle["rear_distance"]

    def distance(of: str) -> float:
        # Logarithmic deviations in units of the spread within the class, so that all quantities count alike.
        off = (math.log(value / rules()[name].values[of]) / rules()[name].relative[of] for name, value in known.items())
        return sum(each * each for each in off)

    return min(classes(), key=distance) if known else USUAL


def typical_spread(name: str, value: float, of: str) -> float | None:
    """Standard deviation of a value given without one [unit of the catalogue]; None without a class rule."""
    require_class(of)
    rule = rules().get(name)
    if rule is None:
        return None
    return rule.spread(value, of)


def typical(of: str, known: Mapping[str, Known] | None = None) -> dict[str, Parameter]:
    """Every parameter for which a class has a rule, with a spread propagated through the rule."""
    require_class(of)
    table = _Typical(of, _with_geometry(dict(known or {})))
    return {name: table.parameter(name) for name in rules() if name in QUANTITIES}


def _with_geometry(known: dict[str, Known]) -> dict[str, Known]:
    front, rear, whole = (known.get(name) for name in ("front_distance", "rear_distance", "wheelbase"))
    if front and rear:
        known["wheelbase"] = Known(front.value + rear.value)
        known["front_share"] = Known(rear.value / known["wheelbase"].value)
    elif whole and (front or rear):
        share = (whole.value - front.value if front else rear.value if rear else 0.0) / whole.value
        known["front_share"] = Known(share, 0.02)
    return known


@dataclass
class _Typical:
    kind: str
    known: Mapping[str, Known]
    found: dict[str, Known] = field(default_factory=dict)

    def parameter(self, name: str) -> Parameter:
        value = self.of(name)
        return Parameter(name, value.value, rules()[name].unit, value.standard_deviation, value.source)

    def of(self, name: str) -> Known:
        if name not in self.found:
            self.found[name] = self._made(name)
        return self.found[name]

    def _made(self, name: str) -> Known:
        if name == "rear_share":
            front = self.of("front_share")
            return Known(1.0 - front.value, front.standard_deviation)
        rule, given = rules()[name], self.known.get(name)
        if given is not None:
            spread = given.standard_deviation
            return (
                given if spread is not None else given._replace(standard_deviation=rule.spread(given.value, self.kind))
            )
        value, variance = rule.values[self.kind], rule.relative[self.kind] ** 2
        # First-order propagation of the relative variances of independent factors.
        for quantity, power in rule.powers.items():
            part = self.of(quantity)
            value *= part.value**power
            variance += (power * (part.standard_deviation or 0.0) / part.value) ** 2
        deviation = math.hypot(value * math.sqrt(variance), rule.absolute)
        return Known(value, deviation, f"assumed: typical of the class {self.kind}: {rule.source}")
