"""Parquet, CSV and MATLAB 5 files of a recording; every group of channels with common time stamps has a time column.

In Parquet, row groups cover equal slices of time; within one, shorter groups are padded with nulls at the end, and a
row without a time stamp is padding. The metadata of the schema hold units, sources and notes under the key "tierod", as
JSON; so does the first line of a CSV file. Numbers of a CSV file are written with all digits.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tierod.core.errors import OutputError
from tierod.core.files import replacing
from tierod.core.frames import column_of, native_file
from tierod.io.formats import Writer
from tierod.io.writers.spool import ROWS, FromSpool, Spool, SpooledGroup

# Time that one row group covers [s]: short enough for the memory, long enough to read the file at full speed
SLICE = 60.0

_MOST = 100_000  # Largest number of row groups: a recording of days gets longer ones


def write_parquet(spool: Spool, path: str | Path) -> tuple[str, ...]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    found = spool.groups()
    columns = [pair for group in found for pair in ((group.clock, "s"), *((c.name, c.unit) for c in group.channels))]
    about = json.dumps(spool.description(found) | {"slice_seconds": SLICE})
    fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in columns]
    schema = pa.schema(fields, metadata={"tierod": about})
    try:
        with (
            replacing(path) as temporary,
            native_file(temporary, "wb") as file,
            pq.ParquetWriter(file, schema, use_dictionary=False, write_page_checksum=True) as writer,
        ):
            for rows in _slices(found):
                length = max(last - first for first, last in rows)
                parts = []
                for group, (first, last) in zip(found, rows, strict=True):
                    parts += [column_of(each, length) for each in (group.time(first, last), *group.values(first, last))]
                # With so large a limit each table becomes one row group.
                writer.write_table(pa.table(parts, schema=schema), row_group_size=1 << 26)
    except pa.ArrowException as error:
        raise OutputError(f"{path} cannot be written: {' '.join(str(error).split())[:160]}") from None
    return ()


def _slices(found: tuple[SpooledGroup, ...]) -> Iterator[list[tuple[int, int]]]:
    """(first, end) rows of every group of channels for each row group, over equal slices of time."""
    ends = [(group.time(0, 1)[0], group.time(group.count - 1, group.count)[0]) for group in found if group.count]
    if not ends:
        yield [(0, 0) for _ in found]
        return
    start, stop = min(first for first, _ in ends), max(last for _, last in ends)
    seconds = max(SLICE, (stop - start) / _MOST)
    at = [0] * len(found)
    for number in range(1, int((stop - start) / seconds) + 2):
        edge = start + seconds * number
        rows = []
        for place, group in enumerate(found):
            end = at[place]
            while end < group.count:
                part = group.time(end, end + ROWS)
                inside = int(np.searchsorted(part, edge))
                end += inside
                if inside < len(part):
                    break
            rows.append((at[place], end))
            at[place] = end
        if any(last > first for first, last in rows):
            yield rows


PARQUET = Writer("Parquet", FromSpool(write_parquet))


def write_csv(spool: Spool, path: str | Path) -> tuple[str, ...]:
    import pyarrow as pa
    import pyarrow.csv as text

    found = spool.groups()
    about = spool.description(found)
    titles = [
        title for group in found for title in (f"{group.clock} [s]", *(_title(c.name, c.unit) for c in group.channels))
    ]
    names = {_title(each.name, each.unit): each.name for each in spool.channels.values()}
    about["channels"] = {title: about["channels"][name] | {"name": name} for title, name in names.items()}
    try:
        with replacing(path) as temporary, temporary.open("wb") as file:
            file.write(f"# tierod {json.dumps(about)}\n".encode())
            file.write((",".join(_quoted(title) for title in titles) + "\n").encode())
            for begin in range(0, max(group.count for group in found), ROWS):
                length = min(max(group.count for group in found) - begin, ROWS)
                parts = []
                for group in found:
                    columns = (group.time(begin, begin + ROWS), *group.values(begin, begin + ROWS))
                    parts += [column_of(each, length) for each in columns]
                table = pa.table(parts, names=[str(place) for place in range(len(parts))])
                text.write_csv(table, file, text.WriteOptions(include_header=False))
            file.flush()
    except pa.ArrowException as error:
        raise OutputError(f"{path} cannot be written: {' '.join(str(error).split())[:160]}") from None
    return ()


def _title(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _quoted(title: str) -> str:
    escaped = title.replace('"', '""')
    return f'"{escaped}"' if any(sign in title for sign in ',"\n\r;\t') else title


CSV = Writer("CSV", FromSpool(write_csv))


_LONGEST = 63  # Largest number of characters of a name in MATLAB
_LARGEST = 2**31 - 1024  # Largest size of a vector in a MATLAB 5 file [bytes]
UNITS = "units"  # Name of the structure of texts with the unit of every vector


def write_mat(spool: Spool, path: str | Path) -> tuple[str, ...]:
    """Write a file for MATLAB's `load`, not packed; returns what the format cannot hold."""
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    found = spool.groups()
    names = _names_in_matlab(list(spool.channels))
    lost = ["MATLAB 5 holds units (in the structure 'units'), but no sources, notes or calendar time"]
    renamed = [f"{name} is {names[name]}" for name in spool.channels if names[name] != name]
    if renamed:
        lost.append(f"names that MATLAB does not allow were changed: {', '.join(renamed[:6])}")
    for group in found:
        if 8 * group.count > _LARGEST:
            raise OutputError(
                f"'{group.channels[0].name}' has {group.count} samples, more than a MATLAB 5 file holds; "
                "write Parquet or MF4"
            )
    units = {names[name]: each.unit for name, each in spool.channels.items()}
    with replacing(path) as temporary, temporary.open("wb") as file:
        # Vectors of one group are written one by one, so that only one of them is in memory.
        parts = _vectors(found[0], names) if len(found) == 1 else _structures(found, names)
        try:
            for name, value in (*parts, (UNITS, units)):
                savemat(file, {name: value}, long_field_names=True, oned_as="column")
        except MatWriteError as error:
            raise OutputError(f"{path} cannot be written as MATLAB 5 ({error}); write Parquet or MF4") from None
    return tuple(lost)


def _vectors(group: SpooledGroup, names: dict[str, str]) -> Iterator[tuple[str, np.ndarray]]:
    yield "time", group.time(0, group.count)
    for place, channel in enumerate(group.channels):
        yield names[channel.name], group.column(place)


def _structures(groups: tuple[SpooledGroup, ...], names: dict[str, str]) -> Iterator[tuple[str, dict[str, np.ndarray]]]:
    for number, group in enumerate(groups):
        yield f"group{number + 1}", dict(_vectors(group, names))


def _names_in_matlab(given: list[str]) -> dict[str, str]:
    """A name that MATLAB allows for every channel: unique, and different from "time" and "units"."""
    taken, found = {"time", UNITS}, {}
    for name in given:
        base = re.sub(r"[^A-Za-z0-9_]", "_", name)[:_LONGEST]
        base = base if base[:1].isalpha() else f"x{base}"[:_LONGEST]
        free = (base, *(f"{base[: _LONGEST - 7]}_{number}" for number in range(2, len(given) + 4)))
        found[name] = next(each for each in free if each not in taken)
        taken.add(found[name])
    return found


MAT = Writer("MATLAB 5", FromSpool(write_mat))
