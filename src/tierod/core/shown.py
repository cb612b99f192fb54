"""Units as people read them: angles in degrees, speeds in km/h, a point for a product."""

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
    """(factor, label) with which a value in this unit is shown: angles in degrees, speeds in km/h."""
    return _SHOWN.get(unit, (1.0, written(unit)))


def written(unit: str) -> str:
    """A unit as people write it, and as a vehicle file or a channel map takes it too: N·m, kg·m²."""
    return unit.replace("**2", "²").replace("**3", "³").replace("**", "^").replace("*", "·")


def in_words(value: float, unit: str, digits: int = 3) -> str:
    """A value as it is shown, with its label.

    Args:
        value: in its unit
        unit: as of the catalogue of signals
        digits: significant ones
    """
    factor, label = shown(unit)
    return f"{factor * value:z.{digits}g} {label}".rstrip()
