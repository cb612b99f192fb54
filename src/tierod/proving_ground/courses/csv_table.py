"""CSV files of courses: columns by name and unit, over time or over distance."""

from __future__ import annotations

import csv
import math
import re
from functools import cache
from pathlib import Path
from typing import get_type_hints

import numpy as np

from tierod.core.block import units
from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.units import scale
from tierod.core.user_files import MOST_DATA_BYTES, read_text
from tierod.proving_ground.parts import Demand, Road, Wind

PLACES = {"time": "s", "distance": "m", "x": "m", "y": "m"}
_HEADING = re.compile(r"\s*(\w+)\s*(?:\[(.*)\])?\s*")


@cache
def known_columns() -> dict[str, tuple[str, str]]:
    """(dotted name, unit) by the short name that a file writes."""
    return {
        name: (f"{part}.{name}", unit)
        for part, kind in (("road", Road), ("wind", Wind), ("demand", Demand))
        for name, unit in zip(get_type_hints(kind), units(kind), strict=True)
    }


def read_table(path: str | Path) -> tuple[str, dict[str, np.ndarray]]:
    """Description (from lines that begin with #) and columns in SI units by short name.

    The first line that is not a remark names the columns, with a unit where it is not the SI one: `speed [km/h]`.

    Args:
        path: of the file

    Raises:
        ParameterError: it cannot be read; an unknown column or unit, a value that is no number; the line is told
    """
    path = Path(path)
    text = read_text(path, "the course file", ParameterError, "give a CSV file", MOST_DATA_BYTES)
    lines = text.splitlines()
    remarks = [line.lstrip("# ").strip() for line in lines if line.startswith("#")]
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    if len(rows) < 3:
        raise ParameterError(f"{path}: a course needs a line of column names and at least two rows of numbers")
    (line, header), *body = rows
    names, scales = _heading(header, f"{path}, line {line}")
    values = np.array([_numbers(text, len(names), f"{path}, line {number}") for number, text in body])
    columns = {
        name: np.asarray(convert(values[:, place]), float)
        for place, (name, convert) in enumerate(zip(names, scales, strict=True))
    }
    for name in ("time", "distance"):
        back = np.flatnonzero(np.diff(columns.get(name, np.arange(2.0))) <= 0.0)
        if back.size:
            raise ParameterError(f"{path}, line {body[back[0] + 1][0]}: the {name} does not grow; sort the rows by it")
    return " ".join(remarks), columns


def _heading(header: str, where: str) -> tuple[list[str], list]:
    known = PLACES | {name: unit for name, (_, unit) in known_columns().items()}
    names, scales = [], []
    for text in next(csv.reader([header])):
        match = _HEADING.fullmatch(text)
        if match is None or match[1] not in known:
            given = text.strip() if match is None else match[1]
            raise ParameterError(f"{where}: no column is called '{given}'{nearest(given, known)}")
        if match[1] in names:
            raise ParameterError(f"{where}: the column '{match[1]}' is there twice; leave one out")
        try:
            scales.append(scale(match[2] if match[2] is not None else known[match[1]], known[match[1]]))
        except InputError as error:
            raise ParameterError(f"{where}: column '{match[1]}': {error}") from None
        names.append(match[1])
    return names, scales


def _numbers(text: str, count: int, where: str) -> list[float]:
    fields = next(csv.reader([text]))
    if len(fields) != count:
        raise ParameterError(f"{where}: {len(fields)} values, but there are {count} columns")
    try:
        values = [float(field) for field in fields]
    except ValueError as error:
        raise ParameterError(f"{where}: {error}; write numbers with a decimal point") from None
    if not all(map(math.isfinite, values)):
        raise ParameterError(f"{where}: a value is not finite; give a number in every row")
    return values
