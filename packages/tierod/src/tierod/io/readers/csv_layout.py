"""Layout of a text table: delimiter, decimal sign, begin of the data, names and units of the columns."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from tierod.core.errors import InputError
from tierod.core.units import known, split_name, tidy
from tierod.io.formats import DAMAGED, description_in
from tierod.io.readers.clocks import is_time
from tierod.io.readers.source import Column

SAMPLE = 1 << 17  # Number of bytes at the beginning from which the layout is found

SPACES = " "  # Delimiter of a table whose cells are apart by any number of spaces

# Beginning of the first line that the CSV writer writes
COMMENT = "# tierod "

_NUMBER = re.compile(r"^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*$|^\s*[-+]?(inf|infinity)\s*$", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"^\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*$")
_DATE = re.compile(
    r"^\s*(\d{4}-\d\d-\d\d|\d\d\.\d\d\.\d{4}|\d\d-[A-Z][a-z]{2}-\d{4})[T ]\d\d:\d\d|"
    r"^\s*\d\d:\d\d:\d\d([.,]\d{1,9})?\s*$"
)
MISSING = ("", "nan", "NaN", "NAN", "null", "NULL", "None", "n/a", "N/A", "NA", "-", "#N/A", "--")
_SECTION = re.compile(r"^\s*\[([\w ]+)\]\s*$")
_CHANNEL = re.compile(r"^\s*channel(?: name| \d+)?\s*[:=]\s*(.+)$", re.IGNORECASE)
_COMMENT = re.compile(r"^\s*[#%]+\s*")
_WIDE = re.compile(r"\t+| {2,}")
_BEFORE_UNIT = re.compile(r"\s+(?=[\[(])")
_VBOX = {"heading": "deg", "height": "m"}  # units of columns whose titles have none
_NAME_LABELS = ("channel name", "channel", "name", "names", "signal", "channels")
_UNIT_LABELS = ("unit", "units")


@dataclass(frozen=True)
class Layout:
    delimiter: str  # sign between cells
    decimal: str  # decimal sign, "." or ","
    begin: int  # number of bytes before the first line of data
    columns: tuple[Column, ...]  # columns in the order of the file
    numeric: tuple[str, ...]  # names of the columns that hold numbers
    dates: tuple[str, ...]  # names of the columns that hold calendar times, or times of a day
    # an example of a cell of every column that holds neither, by name
    texts: dict[str, str] = field(default_factory=dict)
    # description of the channels by the CSV writer of tierod; empty in any other file
    about: dict[str, Any] = field(default_factory=dict)


def find_layout(data: bytes) -> Layout:
    """The layout of a text table, from enough of its beginning in UTF-8 or Latin-1."""
    lines = _lines(data)
    about = _about(lines)
    if "layout" in about:  # a file of tierod, which may hold a missing value in every cell
        return _layout(lines, ",", ".", about)
    best: tuple[float, str, str] = (0.0, "", "")
    plain = [line for _, line in lines if not line.startswith("#")]
    for delimiter in ",;\t|":
        for decimal in "." if delimiter == "," else ".,":
            best = max(best, (_score(plain, delimiter, decimal), delimiter, decimal))
    # Cells of the others may hold spaces too; tabs keep the places of blank cells, which spaces do not.
    for decimal in "" if best[1] == "\t" else ".,":
        score = _score(plain, SPACES, decimal)
        best = (score, SPACES, decimal) if score > best[0] else best
    if not best[0]:
        raise InputError("holds no table of numbers; export the signals as columns with one row of names above them")
    return _layout(lines, best[1], best[2], about)


def _lines(data: bytes) -> list[tuple[int, str]]:
    """(offset, text) of the first lines; a line that is cut at the end of the sample is left out."""
    sample = data[:SAMPLE]
    parts = sample.splitlines(keepends=True)
    if len(data) > SAMPLE and len(parts) > 1:
        parts.pop()
    found, offset = [], 0
    for part in parts:
        try:
            text = part.decode("utf-8-sig" if not offset else "utf-8")
        except UnicodeDecodeError:
            text = part.decode("latin-1")
        found.append((offset, text.rstrip("\r\n")))
        offset += len(part)
    return found[:2000]


def _cells(line: str, delimiter: str) -> list[str]:
    return line.split() if delimiter == SPACES else next(csv.reader([line], delimiter=delimiter), [])


def _is_number(cell: str, decimal: str) -> bool:
    return bool(_NUMBER.match(cell) or (decimal == "," and _DECIMAL_COMMA.match(cell)))


def _score(lines: list[str], delimiter: str, decimal: str) -> float:
    """Number of numeric cells in the last lines, times their share of all cells; 0 where this is no table."""
    tail = [_cells(line, delimiter) for line in lines[-40:] if line.strip()]
    if not tail:
        return 0.0
    width = Counter(len(row) for row in tail).most_common(1)[0][0]
    rows = [row for row in tail if len(row) == width]
    if width < 2 or len(rows) < 0.5 * len(tail):
        return 0.0
    numbers = sum(_is_number(cell, decimal) for row in rows for cell in row)
    # The decimal point wins a tie.
    return numbers * numbers / (width * len(rows)) + 0.5 * (decimal == ".") if numbers >= len(rows) else 0.0


def _about(lines: list[tuple[int, str]]) -> dict[str, Any]:
    if lines and lines[0][1].startswith(COMMENT):
        try:
            about = description_in(lines[0][1].removeprefix(COMMENT))
            if all(each.get("name") and "unit" in each for each in about["channels"].values()):
                return about
        except (ValueError, TypeError):
            pass
        return {"metadata": {"warnings": [DAMAGED]}}
    return {}


def _layout(lines: list[tuple[int, str]], delimiter: str, decimal: str, about: dict[str, Any]) -> Layout:
    rows = [(offset, _cells(text, delimiter)) for offset, text in lines if text.strip() and not text.startswith("#")]
    body = [cells for _, cells in rows]
    width = Counter(len(cells) for cells in body[-40:]).most_common(1)[0][0]
    below = [cells for cells in body[len(body) // 2 :] if len(cells) == width] or [c for c in body if len(c) == width]
    numeric = [place for place in range(width) if _mostly(below, place, lambda cell: _is_number(cell, decimal))]
    dates = [place for place in range(width) if _mostly(below, place, lambda cell: bool(_DATE.match(cell)))]
    empty = [place for place in range(width) if all(row[place].strip() in MISSING for row in below)]
    first = next(
        (at for at in range(len(body)) if _is_data(body, at, width, [*numeric, *dates], decimal)),
        len(body) - 1,
    )
    header = [cells for cells in body[:first] if 1 < len(cells) <= width and any(map(str.strip, cells))]
    above = [text for offset, text in lines if offset < rows[first][0]]
    lacking = not any(is_time(split_name(cell)[0]) for row in header for cell in row)
    header = _preamble(above, width) or (lacking and _spaced(above, width, delimiter)) or header
    _refuse_lacking_names(header, below, delimiter)
    columns = _columns(header, width)
    columns = tuple(_as_written(column, about) for column in columns)
    cells = {
        place: next((row[place] for row in below if row[place].strip() not in MISSING), "") for place in range(width)
    }
    return Layout(
        delimiter,
        decimal,
        rows[first][0],
        columns,
        tuple(columns[place].name for place in sorted({*numeric, *empty})),
        tuple(columns[place].name for place in dates),
        {columns[place].name: cells[place] for place in range(width) if place not in {*numeric, *dates, *empty}},
        about,
    )


def _preamble(above: list[str], width: int) -> list[list[str]]:
    """Rows of names and units from a list of the channels above the data; empty where there is none.

    Sections of VBOX name the columns, in another one their units; a line "Channel : NAME" names one after the time.
    """
    sections: dict[str, list[str]] = {}
    current: list[str] = []
    for line in above:
        title = _SECTION.match(line)
        current = sections.setdefault(title[1].lower(), []) if title else current
        if not title and line.strip():
            current.append(line)
    names = " ".join(sections.get("column names", [])).split()
    if len(names) == width:
        titles = sections.get("header", [])
        last = [line.split()[-1] for line in titles] if len(titles) == width else [""] * width
        own = sections.get("channel units", [])  # of the columns after those that every logger has
        last = [*last[: width - len(own)], *map(str.strip, own)] if len(own) < width else last
        return [names, [_VBOX.get(name, unit if known(unit) else "") for name, unit in zip(names, last, strict=True)]]
    listed = [found[1].strip() for line in above if (found := _CHANNEL.match(line))]
    return [["time", *listed]] if len(listed) == width - 1 else [listed] if len(listed) == width else []


def _spaced(above: list[str], width: int, delimiter: str) -> list[list[str]]:
    """Rows of titles in comments, or of titles that hold spaces and are two or more spaces apart; else empty."""
    comments = [_COMMENT.sub("", line) for line in above if _COMMENT.match(line)]
    for lines in (above, comments):
        narrow = [_cells(_BEFORE_UNIT.sub("", line) if delimiter == SPACES else line, delimiter) for line in lines]
        wide = [_WIDE.split(line.strip()) for line in lines if delimiter == SPACES]
        for rows in (narrow, wide):
            rows = [row for row in rows if len(row) == width]
            first = next((at for at, row in enumerate(rows) if is_time(split_name(row[0])[0])), None)
            if first is not None:
                return rows[first:]
    return []


def _refuse_lacking_names(header: list[list[str]], below: list[list[str]], delimiter: str) -> None:
    """Refuse a table with names for half of its columns, as where a decimal comma doubles the number of cells."""
    width = sum(any(row[place].strip() not in MISSING for row in below) for place in range(len(below[0])))
    named = max((sum(map(bool, cells)) for cells in header), default=width)
    if delimiter == "," and width > 2 and named <= (width + 2) // 2:
        found = f"has {named} names above {width} columns"
        if named not in (width // 2, (width + 1) // 2) or any("." in cell for cells in below for cell in cells):
            raise InputError(f"{found}; write one row of names above the numbers, with a name for every column")
        raise InputError(
            f"{found}: its numbers have a decimal comma, and commas also separate the columns; export it with "
            "semicolons, or with a decimal point"
        )


def _as_written(column: Column, about: Mapping[str, Any]) -> Column:
    """The column under the name that the CSV writer of tierod recorded, else unchanged."""
    entry = about.get("channels", {}).get(column.name)
    return column if entry is None else Column(entry["name"], entry["unit"], entry["name"])


def _mostly(rows: list[list[str]], place: int, test: Callable[[str], bool]) -> bool:
    filled = [row[place] for row in rows if row[place].strip() not in MISSING]
    return bool(filled) and sum(map(test, filled)) > 0.6 * len(filled)


def _is_data(body: list[list[str]], at: int, width: int, places: list[int], decimal: str) -> bool:
    """Whether the data begin here: this row and the next ones have numbers in the columns of numbers."""
    for cells in body[at : at + 3]:
        if len(cells) != width:
            return False
        filled = [cells[place] for place in places if cells[place].strip() not in MISSING]
        good = sum(_is_number(cell, decimal) or bool(_DATE.match(cell)) for cell in filled)
        if not filled or good < 0.7 * len(filled):
            return False
    return True


def _columns(header: list[list[str]], width: int) -> tuple[Column, ...]:
    titles, units = _titles([[cell.strip() for cell in row] + [""] * (width - len(row)) for row in header], width)
    columns, seen = [], Counter[str]()
    for place, (title, unit) in enumerate(zip(titles, units, strict=True)):
        bare, inside = split_name(title)
        seen[title] += 1
        name = title or f"column {place + 1}"
        name = name if seen[title] == 1 or not title else f"{name}.{seen[title]}"
        columns.append(Column(name, unit or inside, bare or name))
    return tuple(columns)


def _titles(header: list[list[str]], width: int) -> tuple[list[str], list[str]]:
    """Names and units of the columns, from the rows above the data."""
    nothing = [""] * width
    if not header:
        return nothing, nothing
    labelled = {row[0].lower(): row for row in header}
    label = next((label for label in _NAME_LABELS if label in labelled and _repeats(labelled[label])), None)
    if label is not None:
        units = next((labelled[name] for name in _UNIT_LABELS if name in labelled), nothing)
        names = ["time" if cell.lower() == label else cell for cell in labelled[label]]
        return names, ["" if cell.lower() in _UNIT_LABELS else cell for cell in units]
    if len(header) == 1:
        return header[-1], nothing
    header = [[cell.removeprefix("in ") for cell in row] if _all_in(row) else row for row in header]
    upper, lower = header[-2], header[-1]
    for above, below in ((upper, lower), *zip(header[-3:-2], [upper], strict=False)):  # sources may stand below units
        if _are_units(below) and not _are_units(above) and 2 * sum(map(bool, above)) > width:
            return above, below
    if is_time(upper[0]) and lower[0] and known(lower[0]) and tidy(lower[0]) in ("s", "ms", "us", "ns"):
        often = Counter(lower)
        names = [below if below and often[below] == 1 else above for above, below in zip(upper, lower, strict=True)]
        return [upper[0], *names[1:]], [lower[0], *nothing[1:]]
    return lower, nothing


def _repeats(row: list[str]) -> bool:
    """Whether the label is repeated before every channel, above a time column of that channel."""
    return len(row) > 1 and (row.count(row[0]) > 1 or len(row) == 2)


def _all_in(row: list[str]) -> bool:
    """Whether all units of a row are written as "in km/h", which would be inches."""
    return all(cell.startswith("in ") for cell in row if cell)


def _are_units(row: list[str]) -> bool:
    filled = [cell for cell in row if cell]
    return bool(filled) and sum(map(known, filled)) >= 0.5 * len(filled)
