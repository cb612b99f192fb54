"""The ledger of a results folder during a run: rows are written in segments, so that a kill costs only seconds.

A kill can lose a row, but never a result: the next run finds the result by its key, and writes the row again.
"""

from __future__ import annotations

import io
import secrets
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from tierod.core.errors import InputError
from tierod.core.version import __version__
from tierod.fleet import schema
from tierod.fleet.places import Found, Place
from tierod.fleet.results import read_table

if TYPE_CHECKING:
    import pyarrow as pa

FOLDER = "ledger"

MOST_ROWS = 1000  # Largest number of rows that wait for their segment

MOST_SECONDS: Annotated[float, "s"] = 5.0  # Longest time that a row waits for its segment while further rows arrive

MOST_SEGMENTS = 16  # Number of segments above which they are merged at the end of a run

Row = dict[str, Any]


class Ledger:
    """Context manager with the rows by name of their recording; new rows are written as they arrive."""

    def __init__(self, place: Place):
        self.place = place
        self.rows: dict[str, Row] = {}
        self.segments = place.files(FOLDER, ".parquet")
        for path in self.segments:
            for row in rows_of(read_table(place, path, "ledger")):
                self.rows[row["recording_name"]] = row
        self._waiting: list[Row] = []
        self._since = time.monotonic()

    def __enter__(self) -> Ledger:
        return self

    def __exit__(self, *_: object) -> None:
        self.flush()

    def add(self, found: Found, job: str, row: Mapping[str, Any]) -> None:
        about = {"recording_name": found.name, "bytes": found.bytes, "modified": found.modified, "job": job}
        self.put({**about, **row, "time": time.time(), "version": __version__})

    def put(self, row: Row) -> None:
        """Add a complete row; raises as `add`."""
        self.rows[row["recording_name"]] = row
        self._waiting.append(row)
        if len(self._waiting) >= MOST_ROWS or time.monotonic() - self._since > MOST_SECONDS:
            self.flush()

    def flush(self) -> None:
        """Write the waiting rows; raises as `add`."""
        self._since = time.monotonic()
        if self._waiting:
            self._write(self._waiting)
            self._waiting = []

    def holds(self, found: Found, job: str, again: bool) -> bool:
        """Whether the stored outcome of a recording is still valid."""
        row = self.rows.get(found.name)
        if row is None or (row["bytes"], row["modified"], row["job"]) != (found.bytes, found.modified, job):
            return False
        return bool(row["lasting"]) and not (again and row["outcome"] == schema.FAILED)

    def merge(self) -> None:
        """Merge the segments if there are many; a concurrent reader finds every row, some of them twice."""
        self.flush()
        if len(self.segments) > MOST_SEGMENTS:
            old = self.segments
            self.segments = []
            self._write(list(self.rows.values()))
            for path in old:
                self.place.remove(path)

    def _write(self, rows: list[Row]) -> None:
        import pyarrow.parquet as pq

        buffer = io.BytesIO()
        pq.write_table(schema.table_of("ledger", rows), buffer, compression="zstd")
        # Names sort by time, so that the last row of a recording applies.
        path = f"{FOLDER}/{time.time_ns():020d}-{secrets.token_hex(4)}.parquet"
        self.place.write(path, buffer.getvalue(), sync=True)
        self.segments.append(path)


def rows_of(table: pa.Table) -> list[Row]:
    """Rows of a table in the form in which they are added: times as seconds since 1970, maps as dictionaries."""
    import pyarrow as pa

    columns = {}
    for field in table.schema:
        values = table[field.name]
        if pa.types.is_timestamp(field.type):
            columns[field.name] = [None if each is None else each / 1e6 for each in values.cast(pa.int64()).to_pylist()]
        elif pa.types.is_map(field.type):
            columns[field.name] = [None if each is None else dict(each) for each in values.to_pylist()]
        else:
            columns[field.name] = values.to_pylist()
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def prepare(place: Place) -> None:
    """Check that a results folder can be written, before hours of work."""
    import json

    known = place.exists("about.json")
    if known:
        try:
            about = json.loads(place.read("about.json"))
            version = int(str(about["schema"]).removeprefix("tierod.fleet/"))
        except (OSError, ValueError, KeyError, TypeError):
            raise InputError(f"{place.shown('about.json')} is not of 'tierod fleet'; name another --output") from None
        if version > schema.VERSION:
            raise InputError(f"{place.shown()} was written by a later tierod (version {version}); use that one")
        place.write(f"{FOLDER}/.try", b"")
        place.remove(f"{FOLDER}/.try")
    else:
        content = {"schema": f"tierod.fleet/{schema.VERSION}", "tierod": __version__}
        place.write("about.json", (json.dumps(content) + "\n").encode())
