"""The tables of a results folder; their version stands in the metadata of every file.

    findings   one row per finding: a verdict of a monitor, or of a sensor or actuator that a monitor judges
    ledger     one row per recording: judged, skipped or failed, with its reason
    levels     estimates over time, decimated in levels: any zoom reads little

All numbers are SI. A column is null where nothing is known. A later version only adds columns.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyarrow as pa

VERSION = 1
"""Raised where a column changes its meaning or goes."""

NAME = b"tierod.fleet"
"""Key of the schema metadata that holds table and version: "findings/1"."""

JUDGED, SKIPPED, FAILED = "judged", "skipped", "failed"
"""What can become of a recording."""

WHOLE = ""
"""The thing judged, where it is what the monitor watches as a whole: friction, for example."""


@cache
def findings() -> pa.Schema:
    """One row per finding.

    vehicle                 name of the single vehicle in the fleet
    cohort                  labels from the fleet file: batch, supplier, climate, ...
    recording               SHA-256 of the file's content
    recording_name          path or address of the recording
    span                    number of the stretch of a long recording, from 0
    start                   beginning of what was judged, UTC; null where the recording has no date
    start_s, duration_s     the same in the recording's own time, and how long it is [s]
    judged_s                of it that the monitor could judge [s]
    mileage_m               of the vehicle at that time [m]
    temperature_K           mean ambient temperature [K]
    monitor, variant        who judged
    judged                  the thing judged: name of a sensor or actuator; "" for what the monitor watches as a whole
    role                    "sensor", "actuator", or "" for the whole
    quantity, unit          what the estimate is of, in words, and its unit
    status                  healthy, rising, suspect, fault, or why nothing could be judged
    word                    under which a finding is shown: the status; for an estimate estimated, consistent, ...
    since_s                 beginning of the status in the recording's time [s]; null where it holds throughout
    kind                    of a fault, in words; "" where there is none or it is not identifiable
    magnitude, magnitude_deviation, magnitude_unit
                            of a fault
    estimate, deviation     value and one standard deviation [unit]
    nominal, limit          value of the vehicle file, and where a fault begins [unit]
    cause, action           in words
    key                     of the result: content, vehicle, monitors, code and tuning as one digest
    vehicle_digest          of the vehicle's parameters, thresholds and channel map
    tuning                  digest of the monitor's tuning on this vehicle
    version                 of tierod
    """
    import pyarrow as pa

    types = {
        "labels": pa.map_(pa.string(), pa.string()),
        "whole": pa.int32(),
        "time": pa.timestamp("us", tz="UTC"),
        "number": pa.float64(),
        "text": pa.string(),
    }
    return _schema("findings", [(name, types[kind]) for kind, names in _FINDINGS for name in names.split()])


_FINDINGS = (
    ("text", "vehicle"),
    ("labels", "cohort"),
    ("text", "recording recording_name"),
    ("whole", "span"),
    ("time", "start"),
    ("number", "start_s duration_s judged_s mileage_m temperature_K"),
    ("text", "monitor variant judged role quantity unit status word"),
    ("number", "since_s"),
    ("text", "kind"),
    ("number", "magnitude magnitude_deviation"),
    ("text", "magnitude_unit"),
    ("number", "estimate deviation nominal limit"),
    ("text", "cause action key vehicle_digest tuning version"),
)
"""Columns in their order, by kind."""


OF_FLEET = ("vehicle", "cohort", "recording_name", "mileage_m")
"""Columns of the findings that the fleet file decides, and no judgement: they are joined when results are compacted."""


@cache
def ledger() -> pa.Schema:
    """One row per recording that was found.

    recording_name, bytes, modified
                            path or address, size, and the storage's mark of its state (time of change, or ETag)
    recording               SHA-256 of the content; null where it could not be read
    vehicle, cohort, mileage_m
                            as in the findings; vehicle is null where none is known
    outcome                 judged, skipped or failed
    reason                  why it was skipped or failed, or "" for one that was judged
    lasting                 whether the same would come out again; what is not lasting is tried again by the next run
    remarks                 notices for a reader of the result: an overlap in time, monitors that did not run and why
    start, duration_s       as in the findings; null where not known
    findings                number of rows in the findings
    moments                 mean and standard deviation of every signal that was read and varies (SI): equal ones in two
                            files are the same drive
    processor_s             processor time that it took [s]
    memory_bytes            largest resident memory of the process that judged it [bytes]
    key                     of the result
    job                     digest of what was asked of it (vehicle, monitors, code, tuning): with name, bytes and
                            modified it shows whether a row still holds
    time                    when this row was written, UTC
    version                 of tierod
    """
    import pyarrow as pa

    return _schema(
        "ledger",
        [
            ("recording_name", pa.string()),
            ("bytes", pa.int64()),
            ("modified", pa.string()),
            ("recording", pa.string()),
            ("vehicle", pa.string()),
            ("cohort", pa.map_(pa.string(), pa.string())),
            ("mileage_m", pa.float64()),
            ("outcome", pa.string()),
            ("reason", pa.string()),
            ("lasting", pa.bool_()),
            ("remarks", pa.list_(pa.string())),
            ("start", pa.timestamp("us", tz="UTC")),
            ("duration_s", pa.float64()),
            ("findings", pa.int32()),
            ("moments", pa.map_(pa.string(), pa.list_(pa.float64()))),
            ("processor_s", pa.float64()),
            ("memory_bytes", pa.int64()),
            ("key", pa.string()),
            ("job", pa.string()),
            ("time", pa.timestamp("us", tz="UTC")),
            ("version", pa.string()),
        ],
    )


@cache
def levels() -> pa.Schema:
    """One row per bin of one estimate at one level; one file per result, one row group per level, the coarsest first.

    monitor, name, unit     which estimate
    level                   0 is the coarsest; each further one has bins a quarter as wide
    time_s                  left edge of the bin in the recording's time [s]
    lower, upper, mean      of the samples in the bin [unit]; null where it has none
    """
    import pyarrow as pa

    return _schema(
        "levels",
        [
            ("monitor", pa.string()),
            ("name", pa.string()),
            ("unit", pa.string()),
            ("level", pa.int8()),
            ("time_s", pa.float64()),
            ("lower", pa.float32()),
            ("upper", pa.float32()),
            ("mean", pa.float32()),
        ],
    )


def _schema(table: str, fields: list[tuple[str, pa.DataType]]) -> pa.Schema:
    import pyarrow as pa

    return pa.schema(fields, metadata={NAME: f"{table}/{VERSION}".encode()})


def version_in(schema: pa.Schema, table: str) -> int | None:
    """The version of a table of this kind; None where the schema is of something else.

    Args:
        schema: of a file
        table: "findings", "ledger" or "levels"
    """
    name, _, version = (schema.metadata or {}).get(NAME, b"").decode("utf-8", "replace").partition("/")
    return int(version) if name == table and version.isdigit() else None


def table_of(table: str, rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    """Rows as a table; what a row does not have is null.

    Args:
        table: "findings", "ledger" or "levels"
        rows: by the names of the columns; times as seconds since 1970, maps as dictionaries
    """
    import pyarrow as pa

    whole = {"findings": findings, "ledger": ledger, "levels": levels}[table]()
    times = [each.name for each in whole if pa.types.is_timestamp(each.type)]
    maps = [each.name for each in whole if pa.types.is_map(each.type)]
    made = []
    for row in rows:
        now = dict(row)
        for name in times:
            if now.get(name) is not None:
                now[name] = round(1e6 * now[name])
        for name in maps:
            if now.get(name) is not None:
                now[name] = list(now[name].items())
        made.append(now)
    # One conversion of whole rows: column by column takes ten times as long for the few rows of a result.
    struct = pa.array(made, pa.struct(list(whole)))
    return pa.table(struct.flatten(), schema=whole)


def shown_time(seconds: float) -> str:
    """A time as people read it.

    Args:
        seconds: since 1970, UTC
    """
    try:
        return dt.datetime.fromtimestamp(seconds, dt.UTC).strftime("%Y-%m-%d %H:%M UTC")
    except (OverflowError, OSError, ValueError):
        return f"{seconds:.3g} s after 1970"
