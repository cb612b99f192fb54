"""Initial vehicle file of a car: given values, values of a similar car, and typical values of its class."""

from __future__ import annotations

import math
from collections.abc import Mapping

from tierod.core.errors import ParameterError
from tierod.core.toml import quoted
from tierod.core.units import COUNT
from tierod.vehicles.catalogue import QUANTITIES
from tierod.vehicles.classes import Known, class_of, classes, require_class, rules, typical
from tierod.vehicles.vehicle import Parameter, Vehicle

UNKNOWN = 0.3
"""Relative standard deviation of a value without a class rule, taken from a similar car or given without one."""


def begun(
    known: Mapping[str, Known], of: str | None = None, like: Vehicle | None = None
) -> tuple[str, list[Parameter]]:
    """Class of a car and its initial parameters, each with a standard deviation and a source."""
    if of is None and like is None:
        raise ParameterError(
            f"describe the car: give --class with one of {', '.join(classes())}, or --like with a vehicle of "
            "'tierod vehicles'"
        )
    kind = of or class_of(like) if like else str(of)
    require_class(kind)
    usual = typical(kind, {**_base(like), **known})
    found = {name: each for name, each in usual.items() if name in known or not rules()[name].spread_alone}
    if like is not None:
        found |= _as_like(like, kind, known, usual)
    for name, each in known.items():
        if name in QUANTITIES and name not in usual:
            spread = UNKNOWN * abs(each.value) if each.standard_deviation is None else each.standard_deviation
            found[name] = Parameter(name, each.value, QUANTITIES[name].unit, spread, each.source)
    return kind, [found[name] for name in QUANTITIES if name in found]


def _base(like: Vehicle | None) -> dict[str, Known]:
    """Mass and geometry of a similar car, with the spread between cars of its class."""
    if like is None:
        return {}
    kind, source = class_of(like), f"assumed: typical of a car like {like.name}"
    found = {}
    if "mass" in like:
        found["mass"] = Known(like["mass"], rules()["mass"].relative[kind] * like["mass"], source)
    if "front_distance" in like and "rear_distance" in like:
        whole = like["front_distance"] + like["rear_distance"]
        found["wheelbase"] = Known(whole, rules()["wheelbase"].relative[kind] * whole, source)
        found["front_share"] = Known(like["rear_distance"] / whole)
    return found


def _as_like(
    like: Vehicle, kind: str, known: Mapping[str, Known], usual: Mapping[str, Parameter]
) -> dict[str, Parameter]:
    """Parameters of a similar car, transferred by the rules of the class to the given mass and geometry."""
    there = typical(kind, _base(like))
    found = {}
    for name, theirs in like.parameters.items():
        if name in known or name in ("mass", "front_distance", "rear_distance"):
            continue
        if QUANTITIES[name].torque and not like.calibrated:
            continue
        value, rule = theirs.value, rules().get(name)
        # The ratio of the rule's results cancels the class's own factor, and keeps that of the similar car.
        if rule is not None and rule.powers:
            value *= usual[name].value / there[name].value
        spread = UNKNOWN * abs(value) if rule is None else 0.0
        if rule is not None:
            relative = (usual[name].standard_deviation or 0.0) / abs(usual[name].value) if usual[name].value else 0.0
            spread = max(relative * abs(value), rule.absolute)
        spread = 0.0 if QUANTITIES[name].whole else max(spread, theirs.standard_deviation or 0.0)
        source = f"assumed: typical of a car like {like.name}: {theirs.source.removeprefix('assumed: ')}"
        found[name] = Parameter(name, value, theirs.unit, spread, source)
    return found


def text_of(
    name: str,
    kind: str,
    parameters: list[Parameter],
    channel_map: str | None = None,
    like: str | None = None,
    counts: bool = False,
    database: str | None = None,
) -> str:
    """Text of a vehicle file."""
    if counts:
        parameters = [each for each in parameters if not QUANTITIES[each.name].torque]
    basis = f"the class {kind}" if like is None else f"a car like {like}"
    head = [
        f"name = {quoted(name)}",
        f"description = {quoted(f'{name}: {classes()[kind]}')}",
        f"source = {quoted(f'begun with typical values of {basis}; given values are marked')}",
        'good_for = ["a first look at recordings of this car, with the uncertainty of typical values"]',
        "not_good_for = [",
        '    "narrow bands: typical values differ from this car until drives have identified them",',
        "]",
        f"torque_unit = {quoted(COUNT if counts else 'N*m')}",
    ]
    files = [f"{key} = {quoted(path)}" for key, path in (("map", channel_map), ("dbc", database)) if path is not None]
    head += ["", "[channels]", *files] if files else []
    return "\n".join(head) + "\n" + "".join(map(_table, parameters))


def _table(parameter: Parameter) -> str:
    return (
        f"\n[parameters.{parameter.name}]  # {QUANTITIES[parameter.name].meaning}\n"
        f"value = {_number(parameter.value, 8)}\n"
        f"unit = {quoted(parameter.unit)}\n"
        f"standard_deviation = {_number(parameter.standard_deviation or 0.0, 3)}\n"
        f"source = {quoted(parameter.source)}\n"
    )


def _number(value: float, digits: int) -> str:
    # TOML requires digits on both sides of the decimal point, as repr() writes them.
    return repr(float(f"{value:.{digits}g}")) if math.isfinite(value) else "0.0"
