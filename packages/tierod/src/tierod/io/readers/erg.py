"""Result files of CarMaker (ERG): rows of fixed length, described in a text file beside them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.core.user_files import MOST_DATA_BYTES, read_bytes
from tierod.io.readers.source import Column, Format, Lane, Piece, Source, begins_with

_HEADER = 16
_TYPES = {
    "Float": "f4", "Double": "f8", "LongLong": "i8", "ULongLong": "u8", "Long": "i4", "ULong": "u4", "Int": "i4",
    "UInt": "u4", "Short": "i2", "UShort": "u2", "Char": "i1", "UChar": "u1",
}  # fmt: skip
ROWS = 1 << 15  # Number of rows that are read at a time


class Quantity(NamedTuple):
    """One column of the rows: name, NumPy type, unit, factor and offset of the stored number."""

    name: str
    kind: str
    unit: str
    factor: float
    offset: float


def open_erg(path: Path) -> Source:
    info = path.with_name(path.name + ".info")
    if not info.is_file():
        raise InputError(f"{path} is described in {info}, which is missing; copy both files from the simulation output")
    facts = _facts(read_bytes(info, "the description of the ERG file", most=MOST_DATA_BYTES).decode("latin-1"))
    try:
        order = "<" if facts["File.ByteOrder"] == "LittleEndian" else ">"
        quantities = _quantities(facts)
        # Fields are named by number: quantities of bytes, which fill gaps between the others, may share a name.
        row = np.dtype([(str(number), order + each.kind) for number, each in enumerate(quantities)])
    except (KeyError, ValueError, TypeError) as error:
        raise InputError(f"{info} is damaged and does not describe {path} ({error}); copy both files again") from None
    count, rest = divmod(path.stat().st_size - _HEADER, row.itemsize)
    clock = next((number for number, each in enumerate(quantities) if each.name == "Time"), None)
    if clock is None or count < 1:
        raise InputError(f"{path} holds no {'quantity Time' if clock is None else 'row'}; simulate with Time stored")
    warnings = (f"the file is cut off: its last row has {rest} of {row.itemsize} bytes",) if rest else ()
    numbers = {each.name: place for place, each in enumerate(quantities) if each.kind[0] != "S" and place != clock}

    def lane(names: Sequence[str]) -> Lane:
        with path.open("rb") as file:
            file.seek(_HEADER)
            for begin in range(0, count, ROWS):
                rows = np.frombuffer(file.read(min(ROWS, count - begin) * row.itemsize), dtype=row)
                time = rows[str(clock)].astype(float)
                channels = [_channel(quantities[numbers[name]], time, rows[str(numbers[name])]) for name in names]
                yield Piece(channels, min((begin + ROWS) / count, 1.0))

    columns = tuple(Column(name, quantities[place].unit) for name, place in numbers.items())
    return Source(columns, lambda names: [lane(names)], {"format": "CarMaker ERG"}, 0.0, warnings)


def _facts(text: str) -> dict[str, str]:
    found = {}
    for line in text.splitlines():
        key, equal, value = line.partition("=")
        if equal:
            found[key.strip().strip('"')] = value.strip()
    return found


def _quantities(facts: dict[str, str]) -> list[Quantity]:
    found: list[Quantity] = []
    while (name := facts.get(f"File.At.{len(found) + 1}.Name")) is not None:
        kind = facts[f"File.At.{len(found) + 1}.Type"]
        padding = re.fullmatch(r"(\d+) Bytes?", kind)
        about = f"Quantity.{name}."
        factor, offset = float(facts.get(f"{about}Factor", 1.0)), float(facts.get(f"{about}Offset", 0.0))
        unit = facts.get(f"{about}Unit", "")
        typed = f"S{int(padding[1])}" if padding else _TYPES[kind]
        found.append(Quantity(name, typed, "" if unit == "-" else unit, factor, offset))
    if not found:
        raise ValueError("it names no quantity")
    return found


def _channel(quantity: Quantity, time: np.ndarray, stored: np.ndarray) -> Channel:
    values = stored.astype(float)
    if (quantity.factor, quantity.offset) != (1.0, 0.0):
        values = quantity.factor * values + quantity.offset
    return Channel(quantity.name, time, values, quantity.unit, quantity.name)


FORMAT = Format(
    "erg", "CarMaker ERG (.erg, with .erg.info beside it)", (".erg",), lambda content, time: open_erg(content.path),
    begins_with(b"CM-ERG"), whole=True,
)  # fmt: skip
