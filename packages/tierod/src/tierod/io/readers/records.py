"""Recordings with a record for each row or sample: JSON, JSON lines, and long tables of time, name and value."""

from __future__ import annotations

import csv
import json
import math
import re
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, islice
from typing import Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.core.units import split_name
from tierod.io.readers import can_csv
from tierod.io.readers.channel_map import TimeEntry
from tierod.io.readers.clocks import is_time, require_plausible_rate, seconds, unit_of
from tierod.io.readers.content import Allowance, Content, whole_lines
from tierod.io.readers.csv import instant
from tierod.io.readers.frames import Log
from tierod.io.readers.source import Column, Format, Source, source_of, text_begin

_NAMES = (
    "name", "signal", "channel", "variable", "parameter", "signal_name", "channel_name", "metric", "field",
    "signalname", "kanal", "messgroesse", "messgröße", "nom", "nombre",
)  # fmt: skip
_VALUES = ("value", "values", "val", "wert", "messwert", "valeur", "valor", "valore")
_UNITS = ("unit", "units", "einheit", "unité", "unidad")
_WIDEST = 12  # Number of columns up to which a table of time, name and value may have others
BLOCK = 10_000  # Number of frames that are Python objects at a time
WHOLE = 1 << 28  # Largest document that is parsed at once [bytes]; JSON lines may be longer
_LONGEST = 16  # Number of values of a vector or matrix in a record
DEEPEST = 8  # Largest depth of structures within a record

Record = Mapping[str, Any]


def _records(content: Content) -> Iterator[Any]:
    """The records of a JSON document or of JSON lines."""
    if _is_lines(content.head(1 << 16)):
        titles: list[str] = []
        for block in whole_lines(content.blocks(), content.path):
            for line in block.splitlines():
                record = _parsed(line) if line.strip() else None
                if isinstance(record, list) and not titles:
                    titles = list(map(str, record))
                elif line.strip():
                    yield dict(zip(titles, record, strict=False)) if isinstance(record, list) else record
        return
    text = b"".join(content.blocks()) if content.size <= WHOLE else b""
    if not text:
        raise InputError(
            f"{content.path} is one JSON document of {content.size / 1e6:.0f} MB; write JSON lines instead"
        )
    document = _parsed(text)
    if document is None:
        raise InputError(f"{content.path} is no JSON that can be read to its end; export it again")
    while isinstance(document, dict) and len(document) == 1:
        document = next(iter(document.values()))
    yield from _in_document(document)


def _in_document(document: Any) -> Iterator[Any]:
    """The records of a document: listed, by columns, or by a structure with times for each signal."""
    first = document[0] if isinstance(document, list) and document else None
    if isinstance(first, list) and all(isinstance(title, str) for title in first):
        document = {"columns": first, "data": document[1:]}
    if isinstance(document, dict) and _is_split(document):
        titles = [str(title) for title in document["columns"]]
        document = [dict(zip(titles, row, strict=False)) for row in document["data"] if isinstance(row, list)]
    if isinstance(document, list):
        series = [each for each in document if isinstance(each, dict) and _is_series(each)]
        yield from document if not series else (record for each in series for record in _of_series(_name(each), each))
        return
    if not isinstance(document, dict):
        return
    parts = {name: list(each.values()) if _is_indexed(each) else each for name, each in document.items()}
    columns = {name: values for name, values in parts.items() if isinstance(values, list)}
    structures = {name: each for name, each in parts.items() if isinstance(each, dict) and _is_series(each)}
    if structures:
        yield from (record for name, each in structures.items() for record in _of_series(name, each))
    elif any(isinstance(each, dict) for values in columns.values() for each in values[:1]):
        yield from (record for values in columns.values() for record in _in_document(values))
    elif columns:
        clock = next((name for name in columns if is_time(split_name(name)[0])), None)
        rows = len(columns[clock]) if clock else max(map(len, columns.values()))
        columns = {name: values for name, values in columns.items() if len(values) == rows}
        yield from (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))


def _is_split(document: Record) -> bool:
    return all(isinstance(document.get(key), list) for key in ("columns", "data"))


def _is_indexed(value: Any) -> bool:
    """Whether a column has its values under the numbers of their rows."""
    return isinstance(value, dict) and bool(value) and all(key.isdigit() for key in value)


def _is_series(value: Record) -> bool:
    """Whether a structure holds lists beside a list of times."""
    lists = [name for name, each in value.items() if isinstance(each, list)]
    return len(lists) > 1 and any(map(is_time, lists)) and not _is_split(value)


def _name(series: Record) -> str:
    return next((str(value) for key, value in series.items() if key.lower() in _NAMES), "")


def _of_series(name: str, series: Record) -> Iterator[Record]:
    lists = {key: each for key, each in series.items() if isinstance(each, list)}
    clock = next(filter(is_time, lists))
    unit = next((each for key, each in series.items() if key.lower() in _UNITS and isinstance(each, str)), "")
    for key, values in lists.items():
        if key != clock:
            title = name if len(lists) == 2 and name else f"{name}.{key}".strip(".")
            title = f"{title} [{unit}]" if unit and not split_name(title)[1] else title
            yield from ({"time": stamp, title: value} for stamp, value in zip(lists[clock], values, strict=False))


def _is_lines(head: bytes) -> bool:
    first = text_begin(head).split(b"\n", 1)[0].strip()
    try:
        return isinstance(json.loads(first), dict | list) and first != text_begin(head).strip()
    except ValueError:
        return False


def _parsed(text: bytes) -> Any:
    """The content of a JSON text; None where it is damaged."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


def _flat(record: Record, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    for key, value in record.items():
        if isinstance(value, dict) and (found := _quantity(key, value)):
            yield f"{prefix}{found[0]}", found[1]
        elif isinstance(value, dict) and depth < DEEPEST:
            yield from _flat(value, f"{prefix}{key}.", depth + 1)
        elif isinstance(value, list) and len(value) <= _LONGEST and all(map(_is_float, value)):
            names = "xyz" if len(value) == 3 else map(str, range(len(value)))
            yield from ((f"{prefix}{key}.{name}", each) for name, each in zip(names, value, strict=True))
        else:
            yield f"{prefix}{key}", value


def _is_float(value: Any) -> bool:
    return isinstance(value, int | float)


def _quantity(name: str, value: Record) -> tuple[str, Any] | None:
    """Name with unit and value of a structure with these two alone, or of a stamp of ROS."""
    for whole, part in (("secs", "nsecs"), ("sec", "nanosec")):
        if value.keys() == {whole, part} and all(isinstance(each, int) for each in value.values()):
            return "time", value[whole] + 1e-9 * value[part]
    keys = {key.lower(): key for key in value}
    number, unit = (next((keys[key] for key in some if key in keys), None) for some in (_VALUES, _UNITS))
    if number is None or not keys.keys() <= {*_VALUES, *_UNITS}:
        return None
    return (f"{name} [{value[unit]}]" if unit else name), value[number]


def _rows(content: Content) -> Iterator[Any]:
    """The rows of a long table."""
    names: list[str] = []
    delimiter = _long(content.head(1 << 12)) or ","
    for block in whole_lines(content.blocks(), content.path):
        for row in csv.reader(block.decode("utf-8-sig", "replace").splitlines(), delimiter=delimiter):
            if not names:
                names = [] if not row or row[0].startswith("#") else [cell.strip().strip("_") for cell in row]
            elif row:
                yield dict(zip(names, row, strict=True)) if len(row) == len(names) else None


def _titles(row: list[str]) -> list[str]:
    return [split_name(cell.strip().strip('"'))[0].lower().strip("_") for cell in row]


def _long(head: bytes) -> str:
    """Delimiter of a table of time, name and value; "" for another one."""
    lines = [each for each in text_begin(head).decode("utf-8", "replace").splitlines() if not each.startswith("#")]
    for delimiter in ",;\t" if len(lines) > 1 else "":
        names = _titles(lines[0].split(delimiter))
        roles = (
            any(map(is_time, names)),
            any(name in _NAMES for name in names),
            any(name in _VALUES for name in names),
        )
        if all(roles) and len(names) <= _WIDEST:
            named = [
                row[names.index(next(filter(_NAMES.__contains__, names)))]
                for row in csv.reader(lines[1:9], delimiter=delimiter)
                if len(row) == len(names)
            ]
            return delimiter if named and all(_number(cell) is None for cell in named) else ""
    return ""


class _Gathered:
    """Samples of every channel with the times of its records."""

    def __init__(self, content: Content, given: TimeEntry):
        self._allowance = Allowance(content.path, content.size)
        self._given = given
        self.clock = ""
        self.times: dict[str, array[float]] = {}
        self.values: dict[str, array[float]] = {}
        self.units: dict[str, str] = {}
        self.words: Counter[str] = Counter()  # number of values that are no number
        self.lost = self.count = 0

    def add(self, record: Any) -> None:
        self.count += 1
        flat = dict(_flat(record)) if isinstance(record, dict) else {}
        self.clock = self.clock or self._given.column or next((key for key in flat if is_time(split_name(key)[0])), "")
        stamp = _number(flat.get(self.clock), dates=True)
        if stamp is None:
            self.lost += 1
            return
        name, value, unit = (
            next((key for key in flat if split_name(key)[0].lower() in some), "") for some in (_NAMES, _VALUES, _UNITS)
        )
        if value and isinstance(flat.get(name), str):
            self.units.setdefault(flat[name], str(flat.get(unit) or ""))
            others = {key: entry for key, entry in flat.items() if key not in (name, value, unit)}
            flat = {**others, flat[name]: flat[value]}
        for key, entry in flat.items():
            number = _number(entry) if key != self.clock else None
            self.words[key] += number is None and entry not in (None, "")
            if number is not None:
                if key not in self.values:
                    self.times[key], self.values[key] = array("d"), array("d")
                self._allowance.take(16)
                self.times[key].append(stamp)
                self.values[key].append(number)

    def source(self, content: Content) -> Source:
        if not self.values:
            raise InputError(
                f"{content.path} holds no record with a time and a number; write records such as "
                '{"time": 0.01, "vehicle_speed": 13.9}, or name the time in a channel map'
            )
        unit = unit_of(Column(self.clock), self._given)
        head = np.array(max(self.times.values(), key=len)[:4096])
        try:
            require_plausible_rate([(self.clock, unit, head)])
            channels = []
            for name, values in self.values.items():
                time, note = seconds(np.array(self.times[name]), unit, self.clock)
                own = self.units.get(name) or split_name(name)[1]
                channel = Channel(name, time, np.array(values), own, name, note)
                words = f"{self.words[name]} cells are not numbers" if self.words[name] else ""
                channels.append(channel.noted(words))
        except InputError as error:
            raise InputError(f"{content.path}: {error}") from None
        lost = (f"{self.lost} of {self.count} records have no time and were left out",) if self.lost else ()
        source = source_of(channels, {"format": "JSON" if not _long(content.head(1 << 12)) else "CSV"})
        columns = tuple(Column(each.name, each.unit, split_name(each.name)[0]) for each in channels)
        return Source(columns, source.lanes, source.metadata, 0.0, lost)


def _number(value: Any, dates: bool = False) -> float | None:
    if isinstance(value, bool | int | float):
        return float(value)
    if isinstance(value, str):
        try:
            return float(value.replace(",", ".") if value.count(",") == 1 else value)
        except ValueError:
            found = instant(value) if dates else math.nan
            return found if found == found else None
    return None


def _as_table(records: Iterator[Any], names: list[str]) -> Iterator[bytes]:
    """Records of CAN frames as the lines of a table."""
    head = ",".join(names) + "\n"
    while some := list(islice(records, BLOCK)):
        rows = ((record.get(name) for name in names) for record in some if isinstance(record, dict))
        yield (head + "".join(",".join(map(_cell, row)) + "\n" for row in rows)).encode()
        head = ""


def _cell(value: Any) -> str:
    if isinstance(value, list) and all(isinstance(each, int) and 0 <= each < 256 for each in value):
        return bytes(value).hex(" ")
    return str(value).replace(",", "")


def _open_json(content: Content, time: TimeEntry) -> Source | Log:
    records = _records(content)
    first = next(records, None)
    if isinstance(first, dict):
        layout = can_csv.layout_of(b"".join(_as_table(iter([first]), list(first))))
        if layout is not None:
            return can_csv.log_of(content.path.name, layout, lambda: _as_table(_records(content), list(first)))
    return _gathered(content, time, chain([first], records))


def _open_long(content: Content, time: TimeEntry) -> Source:
    return _gathered(content, time, _rows(content))


def _gathered(content: Content, time: TimeEntry, records: Iterable[Any]) -> Source:
    gathered = _Gathered(content, time)
    for record in records:
        gathered.add(record)
    return gathered.source(content)


_JSON = re.compile(rb'^(\{\s*"|\[\s*[\[{"])')
JSON = Format(
    "json", "JSON, JSON lines (.json, .jsonl)", (".json", ".jsonl", ".ndjson"), _open_json,
    lambda head, _: _JSON.match(text_begin(head)) is not None, text=True,
)  # fmt: skip
LONG = Format(
    "long-csv", "table of time, name and value (.csv)", (), _open_long, lambda head, _: bool(_long(head)), text=True,
)  # fmt: skip
