"""Recordings with a record for each row or sample: JSON, JSON lines, and long tables of time, name and value."""

from __future__ import annotations

import csv
import json
import re
from array import array
from collections.abc import Iterator, Mapping
from itertools import islice
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

_NAMES = ("name", "signal", "channel", "variable", "parameter", "signal_name", "channel_name", "metric")
_VALUES = ("value", "values", "val")
_UNITS = ("unit", "units")
BLOCK = 10_000  # Number of frames that are Python objects at a time
WHOLE = 1 << 28  # Largest document that is parsed at once [bytes]; JSON lines may be longer
DEEPEST = 8  # Largest depth of structures within a record

Record = Mapping[str, Any]


def _records(content: Content) -> Iterator[Any]:
    """The records of a JSON document or of JSON lines."""
    if _is_lines(content.head(1 << 16)):
        for block in whole_lines(content.blocks(), content.path):
            for line in block.splitlines():
                if line.strip():
                    yield _parsed(line)
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
    if isinstance(document, dict):  # a list for each column
        columns = {name: values for name, values in document.items() if isinstance(values, list)}
        document = [dict(zip(columns, row, strict=False)) for row in zip(*columns.values(), strict=False)]
    yield from document if isinstance(document, list) else ()


def _is_lines(head: bytes) -> bool:
    first = text_begin(head).split(b"\n", 1)[0].strip()
    try:
        return isinstance(json.loads(first), dict) and first != text_begin(head).strip()
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
        if isinstance(value, dict) and depth < DEEPEST:
            yield from _flat(value, f"{prefix}{key}.", depth + 1)
        else:
            yield f"{prefix}{key}", value


def _rows(content: Content) -> Iterator[Any]:
    """The rows of a long table."""
    names: list[str] = []
    delimiter = _long(content.head(1 << 12)) or ","
    for block in whole_lines(content.blocks(), content.path):
        for row in csv.reader(block.decode("utf-8-sig", "replace").splitlines(), delimiter=delimiter):
            if not names:
                names = [cell.strip() for cell in row]
            elif len(row) == len(names):
                yield dict(zip(names, row, strict=True))


def _long(head: bytes) -> str:
    """Delimiter of a table of time, name and value; "" for another one."""
    first = text_begin(head).split(b"\n", 1)[0].decode("utf-8", "replace")
    for delimiter in ",;\t":
        names = [split_name(cell.strip().strip('"'))[0].lower() for cell in first.split(delimiter)]
        roles = (
            any(map(is_time, names)),
            any(name in _NAMES for name in names),
            any(name in _VALUES for name in names),
        )
        if all(roles) and len(names) <= 5:
            return delimiter
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
        self.lost = self.count = 0

    def add(self, record: Any) -> None:
        self.count += 1
        flat = dict(_flat(record)) if isinstance(record, dict) else {}
        self.clock = self.clock or self._given.column or next((key for key in flat if is_time(split_name(key)[0])), "")
        stamp = _number(flat.get(self.clock))
        if stamp is None:
            self.lost += 1
            return
        name, value, unit = (
            next((key for key in flat if split_name(key)[0].lower() in some), "") for some in (_NAMES, _VALUES, _UNITS)
        )
        if value and isinstance(flat.get(name), str):
            self.units.setdefault(flat[name], str(flat.get(unit) or ""))
            flat = {flat[name]: flat[value]}
        for key, entry in flat.items():
            number = _number(entry) if key != self.clock else None
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
                channels.append(Channel(name, time, np.array(values), own, name, note))
        except InputError as error:
            raise InputError(f"{content.path}: {error}") from None
        lost = (f"{self.lost} of {self.count} records have no time and were left out",) if self.lost else ()
        source = source_of(channels, {"format": "JSON" if not _long(content.head(1 << 12)) else "CSV"})
        columns = tuple(Column(each.name, each.unit, split_name(each.name)[0]) for each in channels)
        return Source(columns, source.lanes, source.metadata, 0.0, lost)


def _number(value: Any) -> float | None:
    if isinstance(value, bool | int | float):
        return float(value)
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            found = instant(value)
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
    return bytes(value).hex() if isinstance(value, list) else str(value).replace(",", "")


def _open_json(content: Content, time: TimeEntry) -> Source | Log:
    records = _records(content)
    first = next(records, None)
    if isinstance(first, dict):
        layout = can_csv.layout_of(b"".join(_as_table(iter([first]), list(first))))
        if layout is not None:
            return can_csv.log_of(content.path.name, layout, lambda: _as_table(_records(content), list(first)))
    gathered = _Gathered(content, time)
    for record in _records(content):
        gathered.add(record)
    return gathered.source(content)


def _open_long(content: Content, time: TimeEntry) -> Source:
    gathered = _Gathered(content, time)
    for record in _rows(content):
        gathered.add(record)
    return gathered.source(content)


_JSON = re.compile(rb'^(\{\s*"|\[\s*\{)')
JSON = Format(
    "json", "JSON, JSON lines (.json, .jsonl)", (".json", ".jsonl", ".ndjson"), _open_json,
    lambda head, _: _JSON.match(text_begin(head)) is not None, text=True,
)  # fmt: skip
LONG = Format(
    "long-csv", "table of time, name and value (.csv)", (), _open_long, lambda head, _: bool(_long(head)), text=True,
)  # fmt: skip
