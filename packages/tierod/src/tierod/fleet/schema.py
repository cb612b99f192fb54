"""Schemas of the tables in a results folder; their version is in the metadata of every file.

    findings   one row per finding: a verdict of a monitor, or of a sensor or actuator that a monitor judges
    ledger     one row per recording: judged, skipped or failed, with its reason
    levels     estimates over time at several resolutions, so that any zoom reads little

All numbers are in SI units. A column is null where a value is unknown. A later version only adds columns.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from tierod.core.files import text_of

if TYPE_CHECKING:
    import pyarrow as pa

VERSION = 2  # Version of the tables, raised when a column is removed or changes its meaning

NAME = b"tierod.fleet"  # Key of the schema metadata that holds table and version, such as "findings/1"

JUDGED, SKIPPED, FAILED = "judged", "skipped", "failed"  # Outcomes of a recording

WHOLE = ""  # Judged element of a finding on the quantity that a monitor watches as a whole, such as friction


@cache
def findings() -> pa.Schema:
    """One row per finding.

    vehicle                 name of the individual vehicle in the fleet
    cohort                  labels from the fleet file: batch, supplier, climate, ...
    recording               SHA-256 of the file's content
    recording_name          path or address of the recording
    span                    number of the span of a long recording, from 0
    start                   start of the judged span, UTC; null if the recording has no date
    start_s, duration_s     the same in the recording's own time, and duration of the span [s]
    judged_s                part of that duration that the monitor could judge [s]
    mileage_m               mileage of the vehicle at that time [m]
    temperature_K           mean ambient temperature [K]
    monitor, variant        monitor that judged, and its variant
    judged                  judged element: name of a sensor or actuator; "" for what the monitor watches as a whole
    role                    "sensor", "actuator", or "" for the whole
    quantity, unit          estimated quantity in words, and its unit
    status                  word of `tierod.core.statuses`: healthy, fault, estimated, ..., or why none is given
    since_s                 beginning of the status in the recording's time [s]; null if it holds throughout
    declared_s, end_s       its declaration and its end [s]; null if it was not declared, or lasts to the end
    kind                    kind of fault, in words; "" if there is none or it is not identifiable
    magnitude, magnitude_deviation, magnitude_unit
                            fault magnitude with one standard deviation, and its unit
    estimate, deviation     value and one standard deviation [unit]
    shared_deviation        part of that deviation that all drives of a car share: the gain of its sensors [unit]
    nominal, limit          fault-free value in the vehicle file, and threshold of a fault [unit]
    cause, action           cause and recommended action in words
    key                     key of the result: digest of content, vehicle, monitors, code and tuning
    vehicle_digest          digest of the vehicle's parameters, thresholds and channel map
    tuning                  digest of the monitor's tuning on this vehicle
    version                 version of tierod
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
    ("text", "monitor variant judged role quantity unit status"),
    ("number", "since_s declared_s end_s"),
    ("text", "kind"),
    ("number", "magnitude magnitude_deviation"),
    ("text", "magnitude_unit"),
    ("number", "estimate deviation shared_deviation nominal limit"),
    ("text", "cause action key vehicle_digest tuning version"),
)
"""Columns in their order, by type."""


OF_FLEET = ("vehicle", "cohort", "recording_name", "mileage_m")
"""Columns of the findings that come from the fleet file; they are joined at compaction, and affect no judgement."""


@cache
def ledger() -> pa.Schema:
    """One row per recording that was found.

    recording_name, bytes, modified
                            path or address, size, and version mark of the storage (time of change, or ETag)
    recording               SHA-256 of the content; null if it could not be read
    vehicle, cohort, mileage_m
                            as in the findings; vehicle is null if unknown
    outcome                 judged, skipped or failed
    reason                  why it was skipped or failed, or "" for one that was judged
    lasting                 whether another try would give the same outcome; if not, the next run tries again
    remarks                 notices for a reader of the result: an overlap in time, monitors that did not run and why
    start, duration_s       as in the findings; null if unknown
    findings                number of rows in the findings
    moments                 mean and standard deviation of every varying signal (SI); equal values in two files
                            indicate the same drive
    processor_s             processor time used [s]
    memory_bytes            largest resident memory of the process that judged it [bytes]
    key                     key of the result
    job                     digest of the settings of the judgement (vehicle, monitors, code, tuning): with name,
                            bytes and modified it decides whether a row is still valid
    time                    time of writing of this row, UTC
    version                 version of tierod
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

    monitor, name, unit     monitor, and name and unit of the estimate
    level                   0 is the coarsest; each further level has bins a quarter as wide
    time_s                  left edge of the bin in the recording's time [s]
    lower, upper, mean      minimum, maximum and mean of the samples in the bin [unit]; null if there are none
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
    """Version of a table; None if the schema is not that of this table."""
    name, _, version = (schema.metadata or {}).get(NAME, b"").decode("utf-8", "replace").partition("/")
    return int(version) if name == table and version.isdigit() else None


def table_of(table: str, rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    """Arrow table of some rows; entries that a row lacks are null."""
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
        made.append({name: _unicode(value) for name, value in now.items()})
    # One conversion of whole rows: column by column takes ten times as long for the few rows of a result.
    struct = pa.array(made, pa.struct(list(whole)))
    return pa.table(struct.flatten(), schema=whole)


def _unicode(value: Any) -> Any:
    """A value without lone surrogates, which one recording could bring, and no table can hold."""
    if isinstance(value, str):
        return text_of(value)
    return type(value)(map(_unicode, value)) if isinstance(value, list | tuple) else value


def shown_time(seconds: float) -> str:
    try:
        return dt.datetime.fromtimestamp(seconds, dt.UTC).strftime("%Y-%m-%d %H:%M UTC")
    except (OverflowError, OSError, ValueError):
        return f"{seconds:.3g} s after 1970"
