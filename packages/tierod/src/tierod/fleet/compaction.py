"""Compaction of one file per result into a partitioned Parquet dataset: findings by the month of the drive.

    results/findings/month=2026-11/findings.parquet

The columns from the fleet file (vehicle, cohort, mileage) are joined here, so that a change of that file requires no
new judgement. A month without a change is not written; every other one is replaced as a whole.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tierod.core.errors import InputError
from tierod.fleet import schema
from tierod.fleet.ledger import Ledger
from tierod.fleet.likeness import alike
from tierod.fleet.places import Place
from tierod.fleet.results import read_table
from tierod.fleet.task import part_of, table_of

if TYPE_CHECKING:
    import pyarrow as pa

FOLDER = "findings"

UNDATED = "unknown"  # Month of recordings without a date

ROWS = 1 << 16  # Rows of a row group; small enough that a query of one vehicle reads little


def mark_doubles(ledger: Ledger) -> None:
    """Mark recordings of the same drive as skipped, except the first by name."""
    names = sorted(name for name, row in ledger.rows.items() if row["outcome"] == schema.JUDGED and row["recording"])
    rows = [ledger.rows[name] for name in names]
    first: dict[str, int] = {}
    same = {at: first[digest] for at, row in enumerate(rows) if first.setdefault(digest := row["recording"], at) != at}
    reasons = dict.fromkeys(same, "byte for byte")
    for original, at in alike(rows):
        if at not in same and original not in same:
            same[at] = original
            both = {*rows[at]["moments"]} & {*rows[original]["moments"]}
            reasons[at] = f"mean and deviation of {len(both)} signals agree"
    for at, original in same.items():
        whose = rows[original]["vehicle"]
        other = "" if whose == rows[at]["vehicle"] else f", which is assigned to the vehicle {whose}"
        reason = f"it is the same drive as {names[original]}{other}: {reasons[at]}; delete one"
        # Not lasting: checked again in every run, since the other recording may have been deleted.
        ledger.put({**rows[at], "outcome": schema.SKIPPED, "reason": reason, "lasting": False})


def mark_overlaps(ledger: Ledger) -> None:
    """Add a remark to overlapping drives of one vehicle: two loggers, a wrong clock, or a wrong vehicle."""
    drives: dict[str, list[dict[str, Any]]] = {}
    for row in ledger.rows.values():
        if row["outcome"] == schema.JUDGED and row.get("start") is not None:
            drives.setdefault(row["vehicle"], []).append(row)
    for rows in drives.values():
        rows.sort(key=lambda row: (row["start"], row["recording_name"]))
        end, name = float("-inf"), ""
        for row in rows:
            remark = f"it overlaps in time with {name}, of the same vehicle"
            if row["start"] < end and remark not in row["remarks"]:
                ledger.put({**row, "remarks": [*row["remarks"], remark]})
            if row["start"] + row["duration_s"] > end:
                end, name = row["start"] + row["duration_s"], row["recording_name"]


def compact(place: Place, ledger: Ledger, fresh: Mapping[str, bytes]) -> pa.Table:
    """Write the findings of all judged recordings, and return them."""
    import pyarrow as pa

    wanted = {name: row for name, row in ledger.rows.items() if row["outcome"] == schema.JUDGED}
    paths = place.files(FOLDER, ".parquet")
    old = {path: read_table(place, path, "findings") for path in paths}
    known = _by_key(old.values())
    tables = []
    for name in sorted(wanted):
        key = wanted[name]["key"]
        tables.append(known[key] if key in known else _read(place, key, fresh))
    whole = pa.concat_tables([schema.findings().empty_table(), *tables])
    counts = [(wanted[name], len(table)) for name, table in zip(sorted(wanted), tables, strict=True)]
    whole = _joined(whole, [row for row, count in counts for _ in range(count)]).combine_chunks()
    _write(place, whole, old)
    return whole


def _by_key(tables: Iterable[pa.Table]) -> dict[str, pa.Table]:
    """Rows of each result by its key; where two recordings have the same content, the rows of the first name."""
    found: dict[str, pa.Table] = {}
    for table in tables:
        keys = table["key"].to_pylist()
        names = table["recording_name"].to_pylist()
        start = 0
        for row in range(1, len(keys) + 1):
            if row == len(keys) or (keys[row], names[row]) != (keys[start], names[start]):
                found.setdefault(keys[start], table.slice(start, row - start))
                start = row
    return found


def _read(place: Place, key: str, fresh: Mapping[str, bytes]) -> pa.Table:
    try:
        return table_of(fresh[key] if key in fresh else place.read(part_of(key)))
    except (OSError, InputError):
        raise InputError(
            f"{place.shown(part_of(key))} is missing or damaged, though the ledger names it; delete the folder "
            f"{place.shown('ledger')} and run the same command again: whole results are kept"
        ) from None


def _joined(table: pa.Table, rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    """Findings with the columns of the fleet file, from rows of the ledger, one for each finding."""
    import pyarrow as pa

    for name in schema.OF_FLEET:
        field = table.schema.field(name)
        values = [list(value.items()) if isinstance(value := row.get(name), dict) else value for row in rows]
        table = table.set_column(table.schema.get_field_index(name), field, pa.array(values, field.type))
    return table


def _write(place: Place, whole: pa.Table, old: Mapping[str, pa.Table]) -> None:
    import pyarrow as pa
    import pyarrow.compute as pc

    months = pc.fill_null(pc.strftime(whole["start"], "%Y-%m"), UNDATED)
    written = set()
    for month in sorted(months.unique().to_pylist()):
        path = f"{FOLDER}/month={month}/findings.parquet"
        part = whole.filter(pc.equal(months, pa.scalar(month)))
        part = part.sort_by([(name, "ascending") for name in ("vehicle", "start", "recording_name", "span")])
        written.add(path)
        if path not in old or _stamp(old[path]) != _stamp(part):
            place.write(path, _content(part), sync=True)
    for path in set(old) - written:
        place.remove(path)


def _content(table: pa.Table) -> bytes:
    import pyarrow.parquet as pq

    buffer = io.BytesIO()
    pq.write_table(table, buffer, compression="zstd", row_group_size=ROWS)
    return buffer.getvalue()


def _stamp(table: pa.Table) -> str:
    import pyarrow as pa

    buffer = io.BytesIO()
    with pa.ipc.new_stream(buffer, schema.findings()) as out:
        for batch in pa.table(table.columns, schema=schema.findings()).combine_chunks().to_batches():
            out.write_batch(batch)
    return hashlib.sha256(buffer.getvalue()).hexdigest()
