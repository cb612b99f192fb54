"""Writing of identified values into a vehicle file, without changing comments, order or anything else."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.toml import quoted
from tierod.core.toml_document import line_of
from tierod.core.units import COUNT, Scale, scale
from tierod.vehicles.classes import Known, class_of, classes, require_class, rules, typical
from tierod.vehicles.vehicle import QUANTITIES, Parameter, Vehicle

_LINE = re.compile(
    r"""(?P<head>\s*[A-Za-z_]+\s*=\s*)(?P<value>"(?:\\.|[^"\\])*"|'[^']*'|[^\s#]+)(?P<tail>\s*(?:\#.*)?)"""
)


@dataclass(frozen=True)
class Change:
    """A new value of a parameter."""

    value: float
    standard_deviation: float  # one sigma, in SI units
    source: str


def changed(text: str, changes: Mapping[str, Change]) -> str:
    """Text of a vehicle file with new values, each in the unit used in the file."""
    before = tomllib.loads(text)
    # Windows line ends are preserved.
    windows = "\r\n" in text
    text = text.replace("\r\n", "\n")
    for name, change in changes.items():
        entry = before.get("parameters", {}).get(name)
        wanted = _entry(name, change, entry)
        text = _added(text, name, wanted) if entry is None else _replaced(text, name, wanted, entry)
    _require_same(before, text, changes)
    return text.replace("\n", "\r\n") if windows else text


def with_thresholds(text: str, of: str, table: Mapping[str, float | str | Mapping[str, float]]) -> str:
    """Text of a vehicle file with thresholds at its end, which replace earlier ones of the same kind."""
    windows, text = "\r\n" in text, text.replace("\r\n", "\n")
    header = re.compile(rf"\[thresholds\.{re.escape(of)}(\..+)?\]\s*(#.*)?")
    kept, inside = [], False
    for line in text.split("\n"):
        if line.lstrip().startswith("["):
            inside = header.fullmatch(line.strip()) is not None
        if not inside:
            kept.append(line)
    plain = [f"{key} = {_written(value)}" for key, value in table.items() if not isinstance(value, Mapping)]
    parts = [[f"[thresholds.{of}]", *plain]]
    for key, value in table.items():
        if isinstance(value, Mapping):
            rows = [f"{quoted(name)} = {_written(number)}" for name, number in value.items()]
            parts.append([f"[thresholds.{of}.{key}]", *rows])
    whole = "\n".join(kept).rstrip() + "".join("\n\n" + "\n".join(part) for part in parts) + "\n"
    # The text is edited line by line, so everything else must be verified to be unchanged.
    if _less_thresholds(text, of) != _less_thresholds(whole, of):
        raise ParameterError(
            f"the older thresholds cannot be replaced; write them as tables [thresholds.{of}], or leave them out"
        )
    return whole.replace("\n", "\r\n") if windows else whole


def _less_thresholds(text: str, of: str) -> dict[str, Any] | None:
    """Content of a vehicle file without one kind of thresholds; None if it is not valid TOML."""
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return None
    thresholds = {name: table for name, table in content.pop("thresholds", {}).items() if name != of}
    return content | {"thresholds": thresholds}


def _written(value: float | str) -> str:
    return quoted(value) if isinstance(value, str) else repr(float(f"{value:.6g}"))


def _entry(name: str, change: Change, entry: Mapping[str, Any] | None) -> dict[str, str]:
    unit = QUANTITIES[name].unit
    written = unit if entry is None else str(entry["unit"])
    factor = 1.0 if written == unit else scale(written, unit).factor
    # TOML requires digits on both sides of the decimal point, as repr() writes them.
    return {
        "value": repr(float(f"{change.value / factor:.8g}")),
        "unit": quoted(written),
        "standard_deviation": repr(float(f"{change.standard_deviation / factor:.3g}")),
        "source": quoted(change.source),
    }


def _added(text: str, name: str, wanted: Mapping[str, str]) -> str:
    lines = "".join(f"{key} = {value}\n" for key, value in wanted.items())
    return f"{text.rstrip()}\n\n[parameters.{name}]\n{lines}"


def _replaced(text: str, name: str, wanted: Mapping[str, str], entry: Mapping[str, Any]) -> str:
    lines = text.split("\n")
    # Every key is located in the current text, because an inserted line shifts those below.
    for key, value in wanted.items():
        if key == "unit":
            continue
        if key not in entry:
            anchor = line_of(text, ("parameters", name, "value")) or 0
            lines.insert(anchor, f"{key} = {value}")
        else:
            number = (line_of(text, ("parameters", name, key)) or 0) - 1
            found = _LINE.fullmatch(lines[number])
            if found is None:
                raise ParameterError(
                    f"line {number + 1}, '{lines[number].strip()[:60]}', cannot be changed where it stands; write the "
                    f"parameter as a table [parameters.{name}] with one key a line"
                )
            lines[number] = f"{found['head']}{value}{found['tail']}"
        text = "\n".join(lines)
    return text


def _require_same(before: dict[str, Any], text: str, changes: Mapping[str, Change]) -> None:
    """Check that nothing but the changed parameters differs, because the text is edited line by line."""
    after = tomllib.loads(text)
    for content in (before, after):
        for name in changes:
            content.get("parameters", {}).pop(name, None)
    if before != after:
        raise ParameterError(
            f"{', '.join(changes)} cannot be changed in this vehicle file without changing more; write every parameter "
            "as a table [parameters.name] with one key a line"
        )


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_UNIT = r"[^-+±%=\d.,:;/'][^+±%=]*?"
_VALUE = re.compile(
    rf"(?P<value>{_NUMBER})(?:/(?P<below>{_NUMBER}))?\s*(?P<unit>{_UNIT})?"
    rf"(?:\s*(?:\+-|\+/-|±)\s*(?P<spread>{_NUMBER})\s*(?:(?P<share>%)|(?P<after>{_UNIT}))?)?\s*"
)

# Quantities of data sheets that a vehicle file expresses as axle distances: unit and plausible range
GEOMETRY: dict[str, tuple[str, tuple[float, float]]] = {
    "wheelbase": ("m", (0.8, 10.0)),
    "front_share": ("", (0.2, 0.8)),
}

EXAMPLE = 'mass=1480, mass=1480+-20, mass="1.48 t +- 3 %" or steering_ratio=1/15.5'


def known_from(assignments: Iterable[str]) -> dict[str, Known]:
    found: dict[str, Known] = {}
    for text in assignments:
        name, sign, value = (part.strip() for part in text.partition("="))
        names = [*QUANTITIES, *GEOMETRY]
        if not sign:
            raise ParameterError(f"'{text}' names no value; write NAME=VALUE, for example {EXAMPLE}")
        if name not in names:
            raise ParameterError(f"no parameter is called '{name}'{nearest(name, names)}")
        if name in found:
            raise ParameterError(f"{name} is given twice; give it once")
        found[name] = _known(name, value)
    _require_one_geometry(found)
    return found


def _known(name: str, text: str) -> Known:
    unit, (low, high) = GEOMETRY.get(name) or (QUANTITIES[name].unit, QUANTITIES[name].plausible)
    read = _VALUE.fullmatch(text)
    if read is None:
        raise ParameterError(f"{name}={text} is not a number; {_written_instead(name, text)}")
    first, after = (read["unit"] or "").strip(), (read["after"] or "").strip()
    # "1480 +- 20 kg" has one unit for both, "1.48 t +- 20 kg" two.
    to_si, of_spread = _scale(name, first or after, unit), _scale(name, after or first, unit)
    value, spread = float(read["value"]), read["spread"]
    if read["below"] is not None:
        if not float(read["below"]):
            raise ParameterError(f"{name}={text} divides by zero; write for example {EXAMPLE}")
        value /= float(read["below"])
    deviation = None
    if spread is not None:
        share = 0.01 * abs(value) * to_si.factor
        deviation = float(spread) * (share if read["share"] else of_spread.factor)
        if deviation < 0.0:
            raise ParameterError(f"{name}={text} has a negative spread; write its magnitude")
    value = to_si(value)
    if not low <= value <= high:
        raise ParameterError(_implausible(name, value, unit, low, high))
    _require_finite(name, text, value, deviation)
    if name in QUANTITIES and QUANTITIES[name].whole:
        if deviation or not value.is_integer():
            raise ParameterError(f"{name}={text} is no whole number; write for example {name}={round(value)}")
        return Known(value, 0.0, f"given: {name}={text}")
    spoken = "" if deviation is not None else "; its spread is that of the class"
    return Known(value, deviation, f"given: {name}={text}{spoken}")


def _written_instead(name: str, text: str) -> str:
    if ratio := re.fullmatch(rf"({_NUMBER})\s*:\s*({_NUMBER})", text):
        return f"write a ratio as {name}={ratio[1]}/{ratio[2]}"
    if re.search(r"\d[,']\d", text):
        one_comma = re.fullmatch(r"[^.,']*\d,\d[^.,']*", text) and not re.search(r",\d{3}(?!\d)", text)
        example = f"{name}={text.replace(',', '.')}" if one_comma else "mass=1480.5"
        return f"write a decimal point, and no mark between thousands: {example}"
    return f"write for example {EXAMPLE}"


def _scale(name: str, written: str, unit: str) -> Scale:
    try:
        found = scale(written, unit) if written else Scale(1.0)
    except InputError as error:
        raise ParameterError(f"{name}: {error}") from None
    if found.offset or written == COUNT:
        raise ParameterError(f"{name}: give it in {unit or 'no unit'}, not in {written}")
    return found


def _require_finite(name: str, text: str, value: float, deviation: float | None) -> None:
    if not math.isfinite(value) or not math.isfinite(deviation or 0.0):
        raise ParameterError(f"{name}={text} is not a finite number; write for example {EXAMPLE}")


def _implausible(name: str, value: float, unit: str, low: float, high: float) -> str:
    hint = "check the value and its unit"
    if name == "steering_ratio" and value > 1.0:
        hint = f"it is the road wheel angle per steering wheel angle: write steering_ratio=1/{value:g}"
    if name == "front_share" and 20.0 <= value <= 80.0:
        hint = f"write a share, front_share={value / 100.0:g}"
    return (
        f"{name} is {f'{value:g} {unit}'.strip()}, but a road vehicle lies between {low:g} and "
        f"{f'{high:g} {unit}'.strip()}; {hint}"
    )


def _require_one_geometry(known: dict[str, Known]) -> None:
    """Check that wheelbase, axle distances and front share do not over-determine the geometry."""
    distances = [name for name in ("front_distance", "rear_distance") if name in known]
    if "front_share" in known and distances:
        raise ParameterError(f"front_share and {distances[0]} state the same in two ways; give one of them")
    if "wheelbase" not in known:
        return
    whole = known["wheelbase"].value
    total = sum(known[name].value for name in distances)
    if (len(distances) == 2 and not math.isclose(total, whole, abs_tol=5e-3)) or total > whole + 5e-3:
        raise ParameterError(
            f"{' plus '.join(distances)} is {total:g} m, and the wheelbase is {whole:g} m; leave one of them out"
        )


# Relative standard deviation of a value without a class rule, taken from a similar car or given without one
UNKNOWN = 0.3


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
