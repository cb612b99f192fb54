"""Judgement of recordings in an Arrow table, as a pure function for Spark, Ray Data and other engines.

findings = judge_table(table, "midsize-eps")                       # one row per recording, or its samples
frame.mapInArrow(partial(judge_batches, parameters="midsize-eps"), schema)   # PySpark
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tierod.core.arrow import calendar_seconds
from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Recording
from tierod.experiments.fingerprint import fingerprint
from tierod.fleet import schema
from tierod.fleet.judging import Asked, judge
from tierod.fleet.stamps import code, vehicle_digest
from tierod.io.readers import SHARE_READ
from tierod.monitors.harness.pieces import CHUNK
from tierod.monitors.together import Chosen, usual
from tierod.vehicles import Vehicle, load

if TYPE_CHECKING:
    import pyarrow as pa

TIME, RECORDING, VEHICLE, START, MILEAGE = "time", "recording", "vehicle", "start", "mileage_m"
"""Columns with a fixed meaning; every other numeric column is a signal of the catalogue, in SI."""

NOT_JUDGED = "not available"
"""Status in the row of a recording that could not be judged; its cause states why."""


def judge_table(
    table: pa.Table, parameters: str | Vehicle, monitors: Sequence[str] = (), shortest: float = 30.0
) -> pa.Table:
    """Findings of the recordings in a table; reads and writes no files except that of the vehicle.

    Args:
        table: either one row per recording, with lists of numbers in `time` [s] and in the columns of the signals; or
            one row per sample, with numbers in them. `recording` names a recording (without it a table of samples is
            one recording), `vehicle` its vehicle, `start` is its start (timestamp), `mileage_m` the mileage [m]
        parameters: vehicle, its name, or the path of its file
        monitors: monitors as NAME or NAME:VARIANT; if empty, every one that can run
        shortest: shortest duration of a recording that is judged [s]

    Returns:
        a table as in `tierod.fleet.schema.findings`; a recording that could not be judged has one row without a
        monitor, with the status "not available" and the reason as its cause

    Raises:
        InputError: there is no column `time`
        ParameterError: there is no such vehicle or monitor
    """
    car = parameters if isinstance(parameters, Vehicle) else load(parameters)
    asked = Asked(tuple(map(Chosen.parse, monitors)) or usual(), shortest=shortest)
    if TIME not in table.column_names:
        raise InputError(f"the table has no column '{TIME}', only {', '.join(table.column_names[:12])}; name it so")
    rows: list[dict[str, Any]] = []
    for about, samples in _recordings(table):
        rows += _rows(about, samples, car, asked)
    return schema.table_of("findings", rows)


def judge_batches(
    batches: Iterable[pa.RecordBatch], parameters: str, monitors: Sequence[str] = (), shortest: float = 30.0
) -> Iterator[pa.RecordBatch]:
    """Findings batch by batch, in the form of `mapInArrow` of PySpark: one row per recording.

    Args:
        batches: batches of a table with one row per recording
        parameters, monitors, shortest: as in `judge_table`

    Raises:
        InputError: a batch holds samples, which the engine may have divided anywhere: group them with `applyInArrow`
        ParameterError: as in `judge_table`
    """
    import pyarrow as pa

    for batch in batches:
        table = pa.Table.from_batches([batch])
        if TIME in table.column_names and not _is_list(table.schema.field(TIME).type):
            raise InputError(
                f"'{TIME}' holds numbers and not lists, so that a batch may end in the middle of a recording; group "
                "the samples by recording (PySpark: groupBy('recording').applyInArrow) and call judge_table"
            )
        yield from judge_table(table, parameters, monitors, shortest).combine_chunks().to_batches()


def _is_list(kind: pa.DataType) -> bool:
    import pyarrow.types as types

    return bool(types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind))


def _recordings(table: pa.Table) -> Iterator[tuple[dict[str, Any], pa.Table]]:
    """(facts about a recording, table of its samples)."""
    import pyarrow as pa
    import pyarrow.compute as pc

    if _is_list(table.schema.field(TIME).type):
        lists = [name for name in table.column_names if _is_list(table.schema.field(name).type)]
        for row in range(len(table)):
            one = table.slice(row, 1).combine_chunks()
            columns = {name: one[name].combine_chunks().flatten() for name in lists}
            counts = {name: len(values) for name, values in columns.items()}
            whole = {name: each for name, each in columns.items() if counts[name] == counts[TIME]}
            yield _about(one) | {"uneven": sorted(set(lists) - set(whole))}, pa.table(whole)
    elif RECORDING in table.column_names:
        for name in pc.unique(table[RECORDING]).to_pylist():
            part = table.filter(pc.equal(table[RECORDING], pa.scalar(name)))
            yield _about(part), _samples(part)
    else:
        yield _about(table), _samples(table)


def _about(part: pa.Table) -> dict[str, Any]:
    """Facts about a recording, from its first row."""
    known = {name: part[name] for name in (RECORDING, VEHICLE, START, MILEAGE) if name in part.column_names}
    found = {name: values[0].as_py() for name, values in known.items() if len(part)}
    if found.get(START) is not None:
        found[START] = float(calendar_seconds(known[START].slice(0, 1))[0])
    return found


def _samples(part: pa.Table) -> pa.Table:
    from tierod.core.arrow import is_number

    numbers = [each.name for each in part.schema if is_number(each.type) and each.name != MILEAGE]
    return part.select(numbers)


def _rows(about: Mapping[str, Any], samples: pa.Table, car: Vehicle, asked: Asked) -> list[dict[str, Any]]:
    digest = _digest(samples)
    of_car = vehicle_digest(car)
    common = {
        "vehicle": about.get(VEHICLE) or car.name,
        "recording": digest,
        "recording_name": about.get(RECORDING),
        "mileage_m": about.get(MILEAGE),
        "key": fingerprint(digest, of_car, asked, code()),
        "vehicle_digest": of_car,
    }
    try:
        if uneven := about.get("uneven"):
            raise InputError(f"{', '.join(uneven)} have not as many samples as '{TIME}'; give them on one clock")
        pieces = _pieces(Recording.from_arrow(samples, TIME))
        found = judge(pieces, asked.together(car), asked, about.get(START))
        if not found.rows:
            raise InputError("; ".join(found.refused.values()))
    except (InputError, ParameterError) as error:
        cause = " ".join(str(error).split())
        return [common | {"start": about.get(START), "judged": "", "role": "", "status": NOT_JUDGED, "cause": cause}]
    return [common | row for row in found.rows]


def _pieces(whole: Recording) -> Iterator[Recording]:
    """A recording in pieces, as it would be read from a file."""
    begin, end = whole.span
    for number in range(int((end - begin) / CHUNK) + 1):
        stop = begin + (number + 1) * CHUNK
        piece = whole.slice(begin + number * CHUNK, stop)
        if any(len(channel.time) for channel in piece.channels.values()):
            share = 1.0 if stop > end else (stop - begin) / (end - begin)
            yield Recording(piece.channels, {**piece.metadata, SHARE_READ: share})


def _digest(samples: pa.Table) -> str:
    """Digest of the numbers, independent of chunks and list types."""
    from tierod.core.arrow import floats

    digest = hashlib.sha256()
    for name in sorted(samples.column_names):
        digest.update(name.encode() + b"\0")
        digest.update(floats(samples[name]).tobytes())
    return digest.hexdigest()
