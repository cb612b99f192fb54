"""Kinds of virtual cars and of their parts, by the names that files use."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, get_args

from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import hints, meaning, members, replaced
from tierod.core.toml import Document, Location, kind_name
from tierod_lab.ground.cars.active_front_car import ActiveFrontCar
from tierod_lab.ground.cars.column_bench import ColumnBench
from tierod_lab.ground.cars.demonstrator_car import DemonstratorCar
from tierod_lab.ground.cars.eps_car import EpsCar, PmEpsCar
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.ground.cars.steer_by_wire_car import SteerByWireCar
from tierod_lab.ground.chassis import TYRES, SingleTrack, TwoTrack, Tyre
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.steering.column_eps import ColumnEps
from tierod_lab.ground.steering.friction_laws import Coulomb, Dahl, DahlPower, LuGre, MaxwellSlip, Stribeck
from tierod_lab.ground.steering.rack_eps import RackEps

_CARS: tuple[type, ...] = (EpsCar, PmEpsCar, SteerByWireCar, ActiveFrontCar, DemonstratorCar, ColumnBench, MotorBench)

KINDS: dict[str, type] = {kind_name(each): each for each in _CARS}
"""Classes of the cars by name."""

_FAMILIES: tuple[tuple[type, ...], ...] = (
    (SingleTrack, TwoTrack),
    (ColumnEps, RackEps),
    (Dahl, DahlPower, Coulomb, MaxwellSlip, Stribeck, LuGre),
)
"""Parts whose fields are declared as protocols; each can replace any other of its family."""

NONE = "none"
"""Name for a part that is left out."""


def car_of(kind: str, document: Document) -> Plant:
    """A car of a kind with the defaults of its class.

    Raises:
        ParameterError: there is no such kind
    """
    if kind not in KINDS:
        raise document.error(("kind",), f"no kind of car is called '{kind}'{nearest(kind, KINDS)}")
    car: Plant = KINDS[kind]()
    return car


def choices(block: Any, path: str = "") -> dict[str, dict[str, type | None]]:
    """Classes that can fill the exchangeable fields of a car, by dotted path and name; None leaves the part out."""
    found: dict[str, dict[str, type | None]] = {}
    kind: Any = type(block)
    for field in dataclasses.fields(block):
        part, place = getattr(block, field.name), f"{path}{field.name}"
        choice = _choice(part, hints(kind)[field.name])
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
    return {place: _name(_at(block, place)) for place in choices(block)}


def _at(block: object, path: str) -> object:
    for name in path.split("."):
        block = getattr(block, name)
    return block


def _name(part: object) -> str:
    return NONE if part is None else kind_name(type(part))


def with_parts(block: Plant, parts: Mapping[str, str], document: Document, location: Location = ("parts",)) -> Plant:
    """A car with other parts, each with the defaults of its class; outer parts are replaced first.

    Raises:
        ParameterError: an unknown path or part
    """
    # Outer parts come first, since they determine which inner parts exist.
    for place, name in sorted(parts.items(), key=lambda part: part[0].count(".")):
        known = choices(block)
        if place not in known:
            raise document.error(
                (*location, place), f"no part of the car that can be chosen is called '{place}'{nearest(place, known)}"
            )
        if name not in known[place]:
            near = nearest(str(name), known[place])
            raise document.error((*location, place), f"no {place} is called '{name}'{near}")
        kind = known[place][name]
        try:
            block = replaced(block, {place: None if kind is None else kind()})
        except ParameterError as error:
            raise document.error((*location, place), str(error)) from None
    return block


def on_tyres(block: Plant, name: str, document: Document, location: Location) -> Plant:
    """A car on tyres of another kind, in the sizes of its own tyres.

    Raises:
        ParameterError: no such tyres, or a car without exchangeable tyres
    """
    known = {each.replace(" ", "-"): tyre for each, tyre in TYRES.items()}
    if name not in known:
        raise document.error(location, f"no tyres are called '{name}'{nearest(name, known)}")
    chassis = getattr(block, "chassis", None)
    if not isinstance(chassis, TwoTrack):
        raise document.error(location, "this car has no tyres to choose from; take one with the chassis two-track")
    front, rear = (_in_size_of(axle.tyre, known[name]) for axle in (chassis.front, chassis.rear))
    changed: Plant = replaced(block, {"chassis": chassis.on_tyres(front, rear)})
    return changed


def _in_size_of(own: Tyre, other: Tyre) -> Tyre:
    return dataclasses.replace(other, radius=own.radius, nominal_load=own.nominal_load)
