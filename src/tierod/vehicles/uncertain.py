"""Vehicles whose parameters are moved within their spread, in standard deviations."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping

from tierod.vehicles.catalogue import QUANTITIES
from tierod.vehicles.classes import class_of, typical_spread
from tierod.vehicles.vehicle import Parameter, Vehicle

LARGE = 0.25
"""Relative standard deviation from which a positive quantity is moved by factors: a quarter less and a quarter more are
then no longer alike, and four of them would pass zero."""

OWN_MODEL = ("_noise", "_drift", "_wander", "_wander_time", "_resolution")
"""Endings of parameters that describe how uncertain a filter or a sensor is: they make the band, and are not moved."""

LIMITS = frozenset(
    ("nominal_friction", "rising_friction", "fault_friction", "noticeable_friction", "baseline_variance")
)
"""What an estimate is judged against: chosen, or judged with its deviation by the monitor itself."""


FREE, BOUND = "rear_distance", "front_distance"
"""Where the wheelbase is known better than the centre of gravity, the first is moved and the second follows."""

SURER = 3.0
"""Ratio of their standard deviations from which that holds."""

FITTING = 0.02
"""Relative difference of wheelbase and sum of the distances up to which they are of one car."""


def bound_distance(vehicle: Vehicle) -> bool:
    """Whether one distance of the axles follows from the other and a wheelbase that the file gives.

    Args:
        vehicle: with standard deviations
    """
    if not {"wheelbase", FREE, BOUND} <= set(vehicle.parameters):
        return False
    known = vehicle.parameters["wheelbase"]
    distances = [vehicle.parameters[name] for name in (FREE, BOUND)]
    whole = sum(each.value for each in distances)
    least = min(each.standard_deviation or 0.0 for each in distances)
    spread = known.standard_deviation
    return spread is not None and SURER * spread < least and abs(whole - known.value) < FITTING * known.value


def is_guess(parameter: Parameter, widest: float) -> bool:
    """Whether a value is known to less than a share of itself.

    Args:
        parameter: of a vehicle
        widest: relative standard deviation up to which it is no guess [-]
    """
    return (parameter.standard_deviation or 0.0) > widest * abs(parameter.value)


def may_move(name: str) -> bool:
    """Whether a parameter describes the car, and not a limit or how uncertain a sensor is.

    Args:
        name: in the catalogue of quantities
    """
    return name not in LIMITS and not name.endswith(OWN_MODEL)


def moved(vehicle: Vehicle, by: Mapping[str, float]) -> Vehicle:
    """The vehicle with parameters that are wrong by so many standard deviations.

    A positive quantity with a large spread is moved by factors (log-normal, its value the median), any other one by
    differences; none leaves the range that the catalogue calls plausible, unless its value does so already. With a
    wheelbase that is known, the centre of gravity moves between the axles.

    Args:
        vehicle: with a standard deviation for each of them
        by: standard deviations by name of the parameter [-]
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
    """The value of a parameter that is wrong by so many standard deviations."""
    low, high = QUANTITIES[each.name].plausible
    low, high = min(low, each.value), max(high, each.value)
    spread = each.standard_deviation or 0.0
    if each.value > 0.0 and low >= 0.0 and spread > LARGE * each.value:
        exponent = by * math.sqrt(math.log1p((spread / each.value) ** 2))
        return min(max(each.value * math.exp(exponent), low), high)
    return min(max(each.value + by * spread, low), high)


class WatchedParameters(Mapping[str, Parameter]):
    """Parameters of a vehicle that remember which of them were read, and whose spread their reader holds itself.

    Args:
        parameters: by name

    `read` are the first, `held` the others, see `held_deviation`.
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
    """Declare that a monitor has the spread of parameters in its own band, so that they are not moved beside it.

    Args:
        vehicle: that the monitor was opened for
        names: of parameters
    """
    if isinstance(vehicle.parameters, WatchedParameters):
        vehicle.parameters.held.update(dict.fromkeys(names))


def held_deviation(vehicle: Vehicle, name: str) -> float:
    """The standard deviation of a parameter, for the band of the monitor that asks; 0 where the file gives none.

    A parameter without one takes that of its class, and is moved.

    Args:
        vehicle: that the monitor was opened for
        name: of the parameter
    """
    deviation = vehicle.parameters[name].standard_deviation
    if deviation is None:
        return 0.0
    hold_spread(vehicle, (name,))
    return deviation


def with_spread(vehicle: Vehicle) -> tuple[Vehicle, tuple[str, ...]]:
    """The vehicle with the spread of its class where a parameter gives none, and the names of those parameters.

    Args:
        vehicle: whose parameters may lack a standard deviation
    """
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
    """A sentence on parameters that took the spread of their class.

    Args:
        vehicle: whose they are
        names: of the parameters; empty gives ""
    """
    if not names:
        return ""
    of = f"of the class '{class_of(vehicle)}'" if "mass" in vehicle else "of a usual column or motor"
    shown = f"{', '.join(names[:3])}{f' and {len(names) - 3} more' if len(names) > 3 else ''}"
    have = "has no standard deviation and takes that" if len(names) == 1 else "have no standard deviation and take that"
    return f"{shown} {have} {of}; give each its standard_deviation in the vehicle file, 0 where the value is exact"
