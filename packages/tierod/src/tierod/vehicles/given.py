"""Parameter values as written on a command line: mass="1.48 t", mass=1480+-20, steering_ratio=1/15.5."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.units import COUNT, Scale, scale
from tierod.vehicles.catalogue import QUANTITIES
from tierod.vehicles.classes import Known

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_UNIT = r"[^-+±%=\d.,:;/'][^+±%=]*?"
_VALUE = re.compile(
    rf"(?P<value>{_NUMBER})(?:/(?P<below>{_NUMBER}))?\s*(?P<unit>{_UNIT})?"
    rf"(?:\s*(?:\+-|\+/-|±)\s*(?P<spread>{_NUMBER})\s*(?:(?P<share>%)|(?P<after>{_UNIT}))?)?\s*"
)

GEOMETRY: dict[str, tuple[str, tuple[float, float]]] = {
    "wheelbase": ("m", (0.8, 10.0)),
    "front_share": ("", (0.2, 0.8)),
}
"""Quantities of data sheets that a vehicle file expresses as axle distances: unit and plausible range."""

EXAMPLE = 'mass=1480, mass=1480+-20, mass="1.48 t +- 3 %" or steering_ratio=1/15.5'


def known_from(assignments: Iterable[str]) -> dict[str, Known]:
    """Values by name, in SI units."""
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
    """Advice on how to write a number that could not be read."""
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
