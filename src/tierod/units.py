"""Units: the one place that asks pint, so that readers, vehicles and the command line convert alike."""

from __future__ import annotations

from functools import cache
from typing import Any

from tierod.errors import InputError

COUNT = "count"
"""The unit of a raw value that nobody has calibrated."""


@cache
def registry() -> Any:
    """The one pint registry of the process; building it takes a third of a second, so nothing does until it must."""
    import pint

    return pint.UnitRegistry()


@cache
def conversion(unit: str, to: str) -> tuple[float, float]:
    """(factor, offset) such that ``value * factor + offset`` is the value in the unit `to`.

    Args:
        unit: as given, in any notation that pint reads ("kN/rad", "deg/s", "degC"); "" for a number
        to: as wanted, in the notation of pint

    Raises:
        InputError: a unit that is not known, or of another dimension; raw counts convert to nothing but counts
    """
    if unit == to:
        return 1.0, 0.0
    given, wanted = _parse(unit), _parse(to)
    if (COUNT in str(given)) != (COUNT in str(wanted)) or given.dimensionality != wanted.dimensionality:
        raise InputError(f"the unit '{unit}' cannot be converted to '{to}'; give a unit of the same kind as '{to}'")
    quantity = registry().Quantity
    offset = float(quantity(0.0, given).to(wanted).magnitude)
    return float(quantity(1.0, given).to(wanted).magnitude) - offset, offset


def convert(value: Any, unit: str, to: str) -> Any:
    """A number or an array in another unit.

    Raises:
        InputError: a unit that is not known, or of another dimension
    """
    factor, offset = conversion(unit, to)
    return value * factor + offset


def _parse(unit: str) -> Any:
    try:
        return registry().parse_units(unit)
    except Exception as error:
        # pint raises its own, tokenize's and Python's exceptions for what it cannot read.
        raise InputError(
            f"'{unit}' is not a unit that can be read; write it like 'N*m', 'deg/s', 'count', or '' for a number"
        ) from error
