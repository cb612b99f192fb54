"""Table of a campaign: one row per drive and monitor, with all figures and the provenance."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, OutputError
from tierod.core.user_files import json_document
from tierod_lab.campaign.figures import Moments
from tierod_lab.campaign.judged import Judged, from_plain
from tierod_lab.campaign.rows import Row

COLUMNS_OF_DRIVE = ("given", "monitor", "outcome_of_drive", "reason", "last_good_s", "recording", "windows")
PROVENANCE = "provenance"
"""Column with all data that reproduce the drive, as JSON."""


def write_table(rows: Sequence[Row], path: Path) -> None:
    """Write the table as Parquet; the names of axis columns start with "axis."."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from tierod.core.files import replacing

    columns = {name: [each[name] for each in map(_flat, rows)] for name in _names(rows)}
    table = pa.table({name: pa.array(values, _kind(pa, name)) for name, values in columns.items()})
    try:
        with replacing(path) as temporary:
            pq.write_table(table, temporary)
    except pa.ArrowException as error:
        raise OutputError(f"{path} cannot be written: {' '.join(str(error).split())[:160]}") from None


def read_table(path: Path) -> list[Row]:
    """The rows of a table; their drives contain the columns of the table."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    if not path.is_file():
        raise InputError(f"{path} is not there; name the folder of a campaign that has been run")
    try:
        rows = pq.read_table(path).to_pylist()
        return [_row(each) for each in rows]
    except (OSError, pa.ArrowException, KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{path} is not a table of a campaign ({reason}); run the campaign again") from None


AXIS = "axis."
_TEXTS = {"status", "headline", "cause", "unit", "outcome"}
_LISTS = {"estimates_fault_free", "estimates_faulty"}
_MOMENTS = ("errors_fault_free", "errors_faulty")
_PARTS = ("count", "mean", "squares")


def _judged_names() -> list[str]:
    names = []
    for field in dataclasses.fields(Judged):
        names += [f"{field.name}.{part}" for part in _PARTS] if field.name in _MOMENTS else [field.name]
    return names


def _names(rows: Sequence[Row]) -> list[str]:
    axes = dict.fromkeys(f"{AXIS}{axis}" for row in rows for axis in row.place)
    return [*axes, *COLUMNS_OF_DRIVE, *_judged_names(), PROVENANCE]


def _flat(row: Row) -> dict[str, Any]:
    recording = row.drive["recording"]
    flat: dict[str, Any] = {f"{AXIS}{axis}": level for axis, level in row.place.items()}
    flat |= {
        "given": row.given,
        "monitor": row.monitor,
        "outcome_of_drive": row.drive["outcome"],
        "reason": row.reason or None,
        "last_good_s": row.drive["last_good_s"],
        "recording": recording["file"] if recording else None,
        "windows": json.dumps(row.drive["windows"]),
        PROVENANCE: json.dumps(row.drive.get("provenance")),
    }
    for name in _judged_names():
        field, _, part = name.partition(".")
        value = None if row.judged is None else getattr(row.judged, field)
        flat[name] = value if value is None or not part else getattr(value, part)
    return flat


def _kind(pa: Any, name: str) -> Any:
    if name in _LISTS:
        return pa.list_(pa.float64())
    if name == "false_alarms" or name.endswith(".count"):
        return pa.int64()
    if name in _TEXTS or name in {*COLUMNS_OF_DRIVE, PROVENANCE} - {"last_good_s"} or name.startswith(AXIS):
        return pa.string()
    return pa.float64()


def _row(flat: dict[str, Any]) -> Row:
    place = {
        name.removeprefix(AXIS): level for name, level in flat.items() if name.startswith(AXIS) and level is not None
    }
    drive = {
        "outcome": flat["outcome_of_drive"],
        "reason": flat["reason"] or "",
        "last_good_s": flat["last_good_s"],
        "windows": json_document(flat["windows"]),
        "recording": None if flat["recording"] is None else {"file": flat["recording"]},
        "provenance": json_document(flat[PROVENANCE]),
    }
    judged = None if flat["status"] is None else from_plain(_nested(flat))
    return Row(place, drive, flat["monitor"], judged, "" if judged else flat["reason"] or "")


def _nested(flat: dict[str, Any]) -> dict[str, Any]:
    values = {field.name: flat.get(field.name) for field in dataclasses.fields(Judged)}
    for name in _MOMENTS:
        values[name] = dataclasses.asdict(Moments(*(flat[f"{name}.{part}"] for part in _PARTS)))
    return values


def monitors_of(rows: Iterable[Row]) -> list[str]:
    """Labels of the monitors, in order."""
    return list(dict.fromkeys(row.monitor for row in rows))
