"""Units for display: angles in degrees, speeds in km/h, a point for a product."""

from __future__ import annotations

import math

DEGREES = 180.0 / math.pi

_SHOWN = {
    "rad": (DEGREES, "°"),
    "rad/s": (DEGREES, "°/s"),
    "rad/s**2": (DEGREES, "°/s²"),
    "m/s": (3.6, "km/h"),
    "count": (1.0, "counts"),
    "percent": (1.0, "%"),
    "": (1.0, ""),
}


def shown(unit: str) -> tuple[float, str]:
    """(factor, label) for the display of a value in this unit: angles in degrees, speeds in km/h."""
    return _SHOWN.get(unit, (1.0, written(unit)))


def written(unit: str) -> str:
    """A unit in the notation for display, which vehicle files and channel maps accept as well: N·m, kg·m²."""
    return unit.replace("**2", "²").replace("**3", "³").replace("**", "^").replace("*", "·")


def counted(number: int, one: str) -> str:
    """A number of things whose plural ends in s: "1 recording", "3 recordings"."""
    return f"{number} {one}{'' if number == 1 else 's'}"


def in_words(value: float, unit: str, digits: int = 3) -> str:
    factor, label = shown(unit)
    return f"{factor * value:z.{digits}g} {label}".rstrip()


def plus_minus(value: float, deviation: float, unit: str = "", signed: bool = False) -> str:
    """A value ± one standard deviation for display, with the label of its unit: "4.01 ± 0.35 N·m".

    Both have the decimals of the first digit of the standard deviation, or of its second where it is below 3.55 of that
    place, as particle physicists round; without one, the value has three digits.
    """
    factor, label = shown(unit)
    value, deviation, sign = factor * value, factor * deviation, "+" if signed else ""
    if not (math.isfinite(deviation) and deviation > 0.0):
        text = f"{value:{sign}z.3g}"
    else:
        decimals = min(max(-math.floor(math.log10(deviation / 3.55)), 0), 9)
        text = f"{value:{sign}z.{decimals}f} ± {deviation:.{decimals}f}"
    return f"{text.replace('-', chr(0x2212))} {label}".rstrip()
