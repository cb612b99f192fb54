"""Typical parameter values of each class of cars, and the spread of the cars within a class."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Annotated, Any, NamedTuple

from tierod.core.errors import ParameterError, nearest
from tierod.core.user_files import read_text, toml
from tierod.vehicles.vehicle import QUANTITIES, SHIPPED, Parameter, Vehicle

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


# Relative standard deviation above which a positive quantity is varied by factors: with symmetric differences, four
# standard deviations would reach zero
LARGE = 0.25

# Suffixes of parameters that describe the uncertainty of a filter or sensor; they define the band and do not vary
OWN_MODEL = ("_noise", "_drift", "_wander", "_wander_time", "_resolution", "_gain_deviation")

# Limits to which an estimate is compared: chosen values, or values whose spread the monitor itself includes
LIMITS = frozenset(
    ("nominal_friction", "rising_friction", "fault_friction", "noticeable_friction", "baseline_variance")
)


# With a well-known wheelbase the first distance is varied and the second one follows
FREE, BOUND = "rear_distance", "front_distance"

SURER = 3.0  # Ratio of axle-distance to wheelbase standard deviation above which the wheelbase counts as well known
FITTING = 0.02  # Largest relative difference between the wheelbase and the sum of the axle distances


def bound_distance(vehicle: Vehicle) -> bool:
    """Whether one axle distance follows from the other and a well-known wheelbase."""
    if not {"wheelbase", FREE, BOUND} <= set(vehicle.parameters):
        return False
    known = vehicle.parameters["wheelbase"]
    distances = [vehicle.parameters[name] for name in (FREE, BOUND)]
    whole = sum(each.value for each in distances)
    least = min(each.standard_deviation or 0.0 for each in distances)
    spread = known.standard_deviation
    return spread is not None and SURER * spread < least and abs(whole - known.value) < FITTING * known.value


def is_guess(parameter: Parameter, widest: float) -> bool:
    """Whether the relative standard deviation of a parameter exceeds a limit."""
    return (parameter.standard_deviation or 0.0) > widest * abs(parameter.value)


def may_move(name: str) -> bool:
    """Whether a parameter describes the car, in a number with a spread; limits and noises of sensors do not."""
    return name not in LIMITS and not QUANTITIES[name].whole and not name.endswith(OWN_MODEL)


def moved(vehicle: Vehicle, by: Mapping[str, float]) -> Vehicle:
    """The vehicle with parameters in error by given numbers of standard deviations.

    A positive quantity with a large spread is varied by factors (log-normal distribution with its value as median), any
    other one by differences; no value leaves the plausible range of the catalogue unless it is outside already. With a
    well-known wheelbase, the centre of gravity moves between the axles.
    """
    parameters = {
        name: dataclasses.replace(each, value=_moved(each, by[name])) if by.get(name) else each
        for name, each in vehicle.parameters.items()
    }
    if by.get(FREE) and bound_distance(vehicle):
        whole = vehicle[FREE] + vehicle[BOUND]
        free = min(parameters[FREE].value, whole - QUANTITIES[BOUND].plausible[0])
        parameters[FREE] = dataclasses.replace(parameters[FREE], value=free)
        parameters[BOUND] = dataclasses.replace(parameters[BOUND], value=whole - free)
    return dataclasses.replace(vehicle, parameters=parameters)


def _moved(each: Parameter, by: float) -> float:
    low, high = QUANTITIES[each.name].plausible
    # A value outside the plausible range is not pulled into it.
    low, high = min(low, each.value), max(high, each.value)
    spread = each.standard_deviation or 0.0
    if each.value > 0.0 and low >= 0.0 and spread > LARGE * each.value:
        exponent = by * math.sqrt(math.log1p((spread / each.value) ** 2))
        return min(max(each.value * math.exp(exponent), low), high)
    return min(max(each.value + by * spread, low), high)


# Parameter with the relative standard deviation of the gain that driver_torque and motor_torque share
GAIN_DEVIATION = "torque_gain_deviation"

# The same for a vehicle file without it: two torques of 10 % each, the motor with the larger share
ASSUMED_GAIN_DEVIATION: Annotated[float, ""] = 0.08


class GainDeviation(NamedTuple):
    """Relative standard deviation of the gain of the torque sensors."""

    value: float
    given: bool  # whether the vehicle file states it; else it is assumed

    def parts(self, size: float) -> tuple[dict[str, float], dict[str, float]]:
        """Its part in the standard deviation of an estimate: what is assumed, and what is given."""
        part = {GAIN_DEVIATION: self.value * size}
        return ({}, part) if self.given else (part, {})


def torque_gain_deviation(vehicle: Vehicle) -> GainDeviation:
    known = vehicle.parameters.get(GAIN_DEVIATION)
    return GainDeviation(ASSUMED_GAIN_DEVIATION, False) if known is None else GainDeviation(known.value, True)


class WatchedParameters(Mapping[str, Parameter]):
    """Parameters of a vehicle that record which of them were read, and which spreads the reader includes itself.

    `read` holds the names of the first, `held` those of the others (see `held_deviation`).
    """

    def __init__(self, parameters: Mapping[str, Parameter]):
        self.read: dict[str, None] = {}
        self.held: dict[str, None] = {}
        self._parameters = parameters

    def __getitem__(self, name: str) -> Parameter:
        found = self._parameters[name]
        self.read[name] = None
        return found

    def __contains__(self, name: object) -> bool:
        return name in self._parameters

    def __iter__(self) -> Iterator[str]:
        return iter(self._parameters)

    def __len__(self) -> int:
        return len(self._parameters)


def hold_spread(vehicle: Vehicle, names: Iterable[str]) -> None:
    """Declare that a monitor's band includes the spread of parameters, so that these are not varied in addition."""
    if isinstance(vehicle.parameters, WatchedParameters):
        vehicle.parameters.held.update(dict.fromkeys(names))


def held_deviation(vehicle: Vehicle, name: str) -> float:
    """Standard deviation of a parameter for the band of the calling monitor; 0 where the file gives none.

    A parameter without a standard deviation is varied with the spread of its class instead.
    """
    deviation = vehicle.parameters[name].standard_deviation
    if deviation is None:
        return 0.0
    hold_spread(vehicle, (name,))
    return deviation


def with_spread(vehicle: Vehicle) -> tuple[Vehicle, tuple[str, ...]]:
    of = class_of(vehicle)
    taken = {
        name: spread
        for name, each in vehicle.parameters.items()
        if each.standard_deviation is None and may_move(name) and (spread := typical_spread(name, each.value, of))
    }
    if not taken:
        return vehicle, ()
    parameters = {
        name: dataclasses.replace(each, standard_deviation=taken[name]) if name in taken else each
        for name, each in vehicle.parameters.items()
    }
    return dataclasses.replace(vehicle, parameters=parameters), tuple(taken)


def in_words(vehicle: Vehicle, names: tuple[str, ...]) -> str:
    """A sentence on parameters with the spread of their class."""
    if not names:
        return ""
    of = f"of the class '{class_of(vehicle)}'" if "mass" in vehicle else "of a usual column or motor"
    shown = f"{', '.join(names[:3])}{f' and {len(names) - 3} more' if len(names) > 3 else ''}"
    have = "has no standard deviation" if len(names) == 1 else "have no standard deviation"
    return (
        f"{shown} {have}; that {of} is assumed; give each its standard_deviation in the vehicle file, 0 where the "
        "value is exact"
    )
