"""Subjects of identification, and the table of parameters before and after identification."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from tierod.core.content import Item, Table
from tierod.core.shown import written
from tierod.methods.identification.experiment import Found
from tierod.report.display import number
from tierod.vehicles import QUANTITIES, Vehicle

_NOTE = "σ and interval hold with residuals that are coloured, and for this model."


class Subject(NamedTuple):
    """A subject of identification.

    Args:
        title: in one word
        summary: description of the method, for the page
        identify: function of vehicle, recordings, names of free parameters, and progress callback
        items: tables and charts of the page
        tables: tables in the terminal
        lines: lines in the terminal, below the tables
        document: entries of the JSON document besides the parameters
        takes_false_alarms: whether `identify` also takes the required hours between false alarms
        signals: returns the signals that are read, so that others can be skipped; None for all
    """

    title: str
    summary: str
    identify: Callable[..., Any]
    items: Callable[[Any], Iterable[Item]]
    tables: Callable[[Any], Sequence[Table]]
    lines: Callable[[Any], Sequence[str]]
    document: Callable[[Any], dict[str, Any]]
    takes_false_alarms: bool = False
    signals: Callable[[], tuple[str, ...] | None] = lambda: None


def before(vehicle: Vehicle) -> dict[str, tuple[float, float | None]]:
    """Value and standard deviation of every parameter in the vehicle file."""
    return {name: (each.value, each.standard_deviation) for name, each in vehicle.parameters.items()}


def found_table(found: Sequence[Found], beyond: str = "") -> Table:
    """Table of every parameter before and after identification."""
    rows = tuple(
        (
            each.name,
            f"{number(each.before)}" + (f" ± {number(each.before_deviation, 2)}" if each.before_deviation else ""),
            number(each.value, 6),
            number(each.deviation, 2),
            f"{number(each.low, 5)} to {number(each.high, 5)}",
            f"{100.0 * each.change:+.2f} %".replace("-", "−") if np.isfinite(each.change) else "–",
            written(QUANTITIES[each.name].unit),
            each.method,
        )
        for each in found
    )
    header = ("parameter", "before", "found", "σ", "95 % interval", "change", "unit", "by")
    return Table("Parameters before and after", header, rows, f"{_NOTE} {beyond}".strip())
