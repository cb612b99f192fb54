"""Typical values of parameters by class of car, and how far the cars of a class differ from them."""

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

USUAL = "midsize"
"""Class of a car of which neither mass nor wheelbase is known."""


class Known(NamedTuple):
    """A value in SI units, and its standard deviation; None where it is not known."""

    value: float
    standard_deviation: float | None = None
    source: str = ""


@dataclass(frozen=True)
class Rule:
    """Rule by which a quantity follows from the class of a car.

    Args:
        name: of the quantity
        unit: SI
        values: by class; with powers the factor of the rule
        powers: value = factor * product of quantity ** power
        relative: standard deviation over the value by class, of a value that is not given
        absolute: further standard deviation in the unit
        given: relative standard deviation of a value that is given without one; None: that of one not given
        source: of both
        spread_alone: the value is only good for a spread: a car has to bring its own
    """

    name: str
    unit: str
    values: Mapping[str, float]
    powers: Mapping[str, float]
    relative: Mapping[str, float]
    absolute: float
    given: float | None
    source: str
    spread_alone: bool = False

    def spread(self, value: float, of: str) -> float:
        """Standard deviation of a value that is given without one, in the unit."""
        relative = self.relative[of] if self.given is None else self.given
        return math.hypot(relative * value, self.absolute)


@cache
def _content() -> dict[str, Any]:
    return toml(read_text(FILE, "the table of classes", ParameterError), FILE, ParameterError)


def classes() -> dict[str, str]:
    """Descriptions of the classes of cars, by name."""
    return dict(_content()["classes"])


def require_class(name: str) -> None:
    """Refuse a class that there is not.

    Raises:
        ParameterError: the message names the nearest ones
    """
    if name not in classes():
        raise ParameterError(f"no class of cars is called '{name}'{nearest(name, classes())}")


@cache
def rules() -> dict[str, Rule]:
    """The rule of every quantity that has one, by name; wheelbase and front_share are no parameters of a file."""
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
    """The class of a vehicle: by name of a shipped one, else the nearest by mass, wheelbase and friction of the tyres.

    Args:
        vehicle: with any parameters; without these three it counts as USUAL
    """
    if vehicle.path.parent == SHIPPED and vehicle.name in _content()["shipped"]:
        return str(_content()["shipped"][vehicle.name])
    known = {name: vehicle[name] for name in ("mass", "tyre_friction") if name in vehicle}
    if "front_distance" in vehicle and "rear_distance" in vehicle:
        known["wheelbase"] = vehicle["front_distance"] + vehicle["rear_distance"]

    def distance(of: str) -> float:
        off = (math.log(value / rules()[name].values[of]) / rules()[name].relative[of] for name, value in known.items())
        return sum(each * each for each in off)

    return min(classes(), key=distance) if known else USUAL


def typical_spread(name: str, value: float, of: str) -> float | None:
    """Standard deviation [unit of the catalogue] of a value that is given without one; None where no class has one.

    Args:
        name: of the parameter
        value: in the unit of the catalogue
        of: class of the car

    Raises:
        ParameterError: no such class
    """
    require_class(of)
    rule = rules().get(name)
    if rule is None:
        return None
    return rule.spread(value, of)


def typical(of: str, known: Mapping[str, Known] | None = None) -> dict[str, Parameter]:
    """Every parameter that a class has a rule for, with the spread that follows from rule and what it is made of.

    Args:
        of: class of the car
        known: given values by name, also of "wheelbase" [m] and "front_share"; they replace the class's

    Raises:
        ParameterError: no such class
    """
    require_class(of)
    table = _Typical(of, _with_geometry(dict(known or {})))
    return {name: table.parameter(name) for name in rules() if name in QUANTITIES}


def _with_geometry(known: dict[str, Known]) -> dict[str, Known]:
    """Wheelbase and share of the weight from given distances of the axles, where those are given."""
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
    """Values of a class, each made once."""

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
        for quantity, power in rule.powers.items():
            part = self.of(quantity)
            value *= part.value**power
            variance += (power * (part.standard_deviation or 0.0) / part.value) ** 2
        deviation = math.hypot(value * math.sqrt(variance), rule.absolute)
        return Known(value, deviation, f"assumed: typical of the class {self.kind}: {rule.source}")
