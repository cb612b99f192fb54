"""Channel map in TOML: which column of a file is which canonical signal.

[signals.driver_torque]
source = "EPS.DriverTorque"   # or a list, whose sum is taken
sign = -1                     # 1 where not given
sign_from = "EPS.Direction"   # column, often a bit: where it is not 0, the source is a magnitude of a negative value
factor = 1.0
offset = 0.0
unit = "deg"                  # of sign * factor * source + offset; where not given, that of the file; "count" stays raw
optional = false              # true: no warning where the file lacks the source
note = "why"

[time]                        # of a table (CSV, Parquet, MATLAB); where not given, the column with such a title
column = "timestamp"
unit = "ms"                   # where not given, that of the title, else s
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, nearest
from tierod.core.signals import SIGNALS
from tierod.core.units import scale
from tierod.core.user_files import read_text, toml


@dataclass(frozen=True)
class Entry:
    """Recipe of one canonical signal from columns of a file."""

    source: tuple[str, ...]  # names of the columns, which are summed
    # unit of sign * factor * source + offset; None where it is that of the columns, and the file states it
    unit: str | None = None
    sign: float = 1.0  # 1 or -1
    factor: float = 1.0  # factor of the source
    offset: float = 0.0  # offset that is added after sign and factor, in `unit`
    optional: bool = False  # whether the file may lack the source
    note: str = ""  # reason for the entry
    sign_from: str = ""  # column that is not 0 where the source, a magnitude, stands for a negative value

    @property
    def columns(self) -> tuple[str, ...]:
        return (*self.source, self.sign_from) if self.sign_from else self.source


@dataclass(frozen=True)
class TimeEntry:
    column: str | None = None  # its name; the first column with such a title where None
    unit: str | None = None  # unit of the time columns; that of their titles where None


GUESSED = TimeEntry()  # No time column is given: column and unit follow from the titles


@dataclass(frozen=True)
class ChannelMap:
    """Entries by canonical signal, path of the file for messages, and time column."""

    entries: dict[str, Entry]
    path: str = "the channel map"
    time: TimeEntry | None = None


_TABLES = ("signals", "time", "title", "notes")

_KEYS: dict[str, tuple[type, ...]] = {
    "source": (str, list),
    "unit": (str,),
    "sign": (int, float),
    "sign_from": (str,),
    "factor": (int, float),
    "offset": (int, float),
    "optional": (bool,),
    "note": (str,),
}


def load_channel_map(path: str | Path) -> ChannelMap:
    path = Path(path)
    text = read_text(path, "the channel map")
    return parse_channel_map(toml(text, f"the channel map {path}"), str(path))


def maps_beside(databases: Iterable[Path]) -> tuple[Path, ...]:
    """The channel maps beside databases: for "car.dbc" it is "car.channels.toml"."""
    candidates = (path.with_name(f"{path.stem}.channels.toml") for path in databases)
    return tuple(path for path in candidates if path.is_file())


def load_maps_beside(paths: Sequence[Path]) -> ChannelMap:
    """The maps beside several databases as one; all entries are optional, since a log may lack some of the messages."""
    entries: dict[str, Entry] = {}
    for path in paths:
        for name, entry in load_channel_map(path).entries.items():
            entries.setdefault(name, replace(entry, optional=True))
    return ChannelMap(entries, ", ".join(map(str, paths)))


def parse_channel_map(document: Mapping[str, object], path: str = "the channel map") -> ChannelMap:
    for key in document:
        if key not in _TABLES:
            raise InputError(f"{path}: the key '{key}' is not known{nearest(key, _TABLES)}")
    time = _time(document["time"], path) if "time" in document else None
    signals = document.get("signals", {})
    if not isinstance(signals, dict) or not (signals or time):
        raise InputError(
            f'{path}: no signals; write a table [signals.NAME] with source = "column of the file" for each'
        )
    entries = {}
    for name, table in signals.items():
        where = f"{path}: [signals.{name}]"
        if name not in SIGNALS:
            raise InputError(f"{where} '{name}' is not a canonical signal{nearest(name, SIGNALS)}")
        if not isinstance(table, dict):
            raise InputError(f'{where} must be a table with source = "column of the file"')
        entries[name] = _entry(table, where)
    return ChannelMap(entries, path, time)


def _time(table: object, path: str) -> TimeEntry:
    keys = ("column", "unit")
    if not isinstance(table, dict) or not table or not all(isinstance(value, str) for value in table.values()):
        raise InputError(f'{path}: [time] must be a table with column = "column of the file", unit = "ms", or both')
    for key in table:
        if key not in keys:
            raise InputError(f"{path}: [time] the key '{key}' is not known{nearest(key, keys)}")
    try:
        scale(table.get("unit", "s"), "s")
    except InputError as error:
        raise InputError(f"{path}: [time] {error}") from None
    return TimeEntry(table.get("column"), table.get("unit"))


def _entry(table: dict[str, Any], where: str) -> Entry:
    for key, value in table.items():
        if key not in _KEYS:
            raise InputError(f"{where} the key '{key}' is not known{nearest(key, _KEYS)}")
        if not isinstance(value, _KEYS[key]) or (isinstance(value, bool) and key != "optional"):
            raise InputError(f"{where} {key} = {value!r} is not {_kind(key)}")
    source = table.get("source")
    sources = (source,) if isinstance(source, str) else tuple(source or ())
    if not sources or not all(isinstance(part, str) and part for part in sources):
        raise InputError(f'{where} needs source = "column of the file"')
    if abs(table.get("sign", 1)) != 1:
        raise InputError(f"{where} sign = {table['sign']} must be 1 or -1; use factor for a scale")
    if not (math.isfinite(table.get("factor", 1.0)) and table.get("factor", 1.0)):
        raise InputError(f"{where} factor = {table['factor']} must be a finite number other than 0")
    if not math.isfinite(table.get("offset", 0.0)):
        raise InputError(f"{where} offset = {table['offset']} must be a finite number")
    return Entry(
        sources,
        table.get("unit"),
        float(table.get("sign", 1)),
        float(table.get("factor", 1.0)),
        float(table.get("offset", 0.0)),
        table.get("optional", False),
        table.get("note", ""),
        table.get("sign_from", ""),
    )


def _kind(key: str) -> str:
    texts = dict.fromkeys(("unit", "note", "sign_from"), "a text")
    return {"source": "a name or a list of names", "optional": "true or false", **texts}.get(key, "a number")
