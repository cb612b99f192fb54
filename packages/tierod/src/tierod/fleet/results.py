"""Reading a results folder: findings and ledger, each as one table.

    results/ledger/*.parquet                     segments in the order of time; the last row of a recording applies
    results/findings/month=2026-11/*.parquet     compacted, by the month of the drive ("unknown" without a date)
    results/levels/KE/KEY.parquet                estimates over time of one result

The folder may be local, or in any storage that fsspec can access: `results`, `s3://bucket/results`.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from tierod.core.errors import InputError
from tierod.fleet import schema
from tierod.fleet.places import Place, place_of

if TYPE_CHECKING:
    import pyarrow as pa


def findings_of(results: str | Path, columns: Iterable[str] | None = None) -> pa.Table:
    """Findings of all judged recordings, sorted by vehicle, time and recording."""
    place = _place(results)
    paths = place.files("findings", ".parquet")
    wanted = None if columns is None else list(columns)
    order = [name for name in ("vehicle", "start", "recording_name", "span") if wanted is None or name in wanted]
    table = _together(place, paths, "findings", wanted)
    return table.sort_by([(name, "ascending") for name in order]) if order else table


def ledger_of(results: str | Path) -> pa.Table:
    """The last row of every recording, sorted by name."""
    import pyarrow as pa

    place = _place(results)
    table = _together(place, place.files("ledger", ".parquet"), "ledger", None)
    last = {name: row for row, name in enumerate(table["recording_name"].to_pylist())}
    return table.take(pa.array(sorted(last.values()), pa.int64())).sort_by("recording_name")


def _place(results: str | Path) -> Place:
    place = place_of(results)
    if not place.exists("ledger"):
        raise InputError(
            f"{results} holds no results of 'tierod fleet': there is no folder 'ledger' in it; name the folder that "
            "was given with --output"
        )
    return place


def _together(place: Place, paths: Iterable[str], table: str, columns: list[str] | None) -> pa.Table:
    import pyarrow as pa

    empty = getattr(schema, table)().empty_table()
    parts = [read_table(place, path, table, columns) for path in paths]
    whole = pa.concat_tables([empty if columns is None else empty.select(columns), *parts])
    return whole.combine_chunks()


OLD_WORD = "word"  # Column of version 1 with the word of an estimate, which the status of a later version is


def read_table(place: Place, path: str, table: str, columns: list[str] | None = None) -> pa.Table:
    """One file of a results folder, in the columns of the current schema."""
    import pyarrow as pa
    import pyarrow.compute as pc
    import pyarrow.parquet as pq

    wanted = getattr(schema, table)()
    try:
        with place.open(path) as source, pq.ParquetFile(source) as file:
            version = schema.version_in(file.schema_arrow, table)
            if version is None or version > schema.VERSION:
                raise InputError(
                    f"{place.shown(path)} is not a table '{table}' of version {schema.VERSION} or earlier "
                    f"({'no version' if version is None else version}); read it with the tierod that wrote it"
                )
            known = [name for name in columns or wanted.names if name in file.schema_arrow.names]
            read = file.read(columns=known)
            if OLD_WORD in file.schema_arrow.names and "status" in known:
                status = pc.coalesce(file.read(columns=[OLD_WORD])[OLD_WORD], read["status"])
                read = read.set_column(known.index("status"), "status", status)
    except (pa.ArrowException, OSError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{place.shown(path)} is damaged ({reason}); delete it and run 'tierod fleet' again") from None
    fields = [wanted.field(name) for name in columns or wanted.names]
    made = [read[f.name].cast(f.type) if f.name in known else pa.nulls(len(read), f.type) for f in fields]
    return pa.table(made, schema=pa.schema(fields, metadata=wanted.metadata))
