"""Task of a worker on one recording: reuse its stored result, or judge it and store the result."""

from __future__ import annotations

import contextlib
import io
import json
import resource
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path, PurePosixPath
from typing import IO, TYPE_CHECKING, Any

from tierod.core.errors import InputError, ParameterError, TierodError
from tierod.core.files import sha256_of, text_of
from tierod.core.frames import native_file
from tierod.fleet import levels, schema
from tierod.fleet.fleet_file import Assigned, Fleet
from tierod.fleet.judging import Asked, Judgement, TooShort, chunk, judge
from tierod.fleet.likeness import TEMPERATURE
from tierod.fleet.places import LOCAL, Found, Place, of_storage, protocol_of, reason_of, storage_of
from tierod.fleet.stamps import code, vehicle_digest
from tierod.monitors.pieces import pieces_of
from tierod.vehicles import Vehicle
from tierod.work.fingerprint import fingerprint
from tierod.work.pool import Passing

if TYPE_CHECKING:
    import pyarrow as pa

FUTURE = 86400.0
"""Lead over the current time beyond which the start of a recording is invalid; time zones differ by less [s]."""


@dataclass(frozen=True)
class Job:
    """Settings by which every recording of a run is judged."""

    results: Place  # the folder of the results
    asked: Asked  # settings of the judgement
    code: str  # digest of the judging code at the beginning of the run
    with_levels: bool = True  # whether estimates over time are kept


@dataclass(frozen=True)
class Task:
    """Judgement of one recording."""

    job: Job  # settings of the run
    found: Found  # the recording
    assigned: Assigned | None  # its vehicle; None if the recording must be opened to determine it
    fleet: Fleet | None = None  # assignment of recordings to vehicles in that case


@dataclass(frozen=True)
class Done:
    """Outcome of a recording."""

    row: Mapping[str, Any]  # row of the ledger
    # rows without the columns from the fleet file, as an Arrow file; None if there are none
    findings: bytes | None = None


def work(task: Task) -> Done:
    """Judge a recording."""
    if task.job.code != code():
        raise Passing("the code of tierod differs from that of the run; install the same, or run again")
    _spare_memory()
    began = time.process_time()
    row: dict[str, Any] = {"outcome": schema.JUDGED, "reason": "", "lasting": True, "remarks": []}
    findings = None
    try:
        with _fetched(task.found) as path:
            row["recording"] = sha256_of(path)
            assigned = task.assigned or _looked_up(task, path)
            row |= {"vehicle": assigned.vehicle, "cohort": assigned.cohort, "mileage_m": assigned.mileage}
            findings = _judged(task.job, path, assigned, row)
    except (InputError, ParameterError) as error:
        skipped = isinstance(error, ParameterError | TooShort | _NoMonitor | _Future)
        row |= _refused(schema.SKIPPED if skipped else schema.FAILED, str(error), not isinstance(error, _Future))
    except Exception as error:
        if isinstance(error, TierodError) or not (isinstance(error, OSError) or of_storage(error)):
            raise
        row |= _refused(schema.FAILED, f"it cannot be read ({reason_of(error).lower()})", lasting=False)
    row["processor_s"] = time.process_time() - began
    row["memory_bytes"] = peak_memory()
    return Done(row, findings)


def peak_memory() -> int:
    """Peak resident memory of this process since its program began [bytes].

    `getrusage` includes what the parent held when it started this process: 340 MB for a worker of 270 MB.
    """
    with contextlib.suppress(OSError):
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _refused(outcome: str, reason: str, lasting: bool) -> dict[str, Any]:
    return {"outcome": outcome, "reason": text_of(" ".join(reason.split())), "lasting": lasting}


class _NoMonitor(InputError):
    """A recording that no monitor can judge."""


class _Future(InputError):
    """A recording whose start lies in the future."""


@cache
def _spare_memory() -> None:
    """Make Arrow use the allocator of the C library: its own retains 40 MB more per process."""
    import pyarrow as pa

    pa.set_memory_pool(pa.system_memory_pool())


@contextmanager
def _fetched(found: Found) -> Iterator[Path]:
    """The recording as a local file; a downloaded copy is removed afterwards."""
    if protocol_of(found.path) == LOCAL:
        yield Path(found.path)
        return
    with tempfile.TemporaryDirectory(prefix="tierod-fleet-") as folder:
        path = Path(folder) / PurePosixPath(found.path).name
        storage_of(found.path).get_file(found.path.partition("://")[2], str(path))
        try:
            yield path
        except (InputError, ParameterError) as error:
            # Messages name the recording, not its temporary copy.
            error.args = (str(error).replace(str(path), found.name),)
            raise


def _looked_up(task: Task, path: Path) -> Assigned:
    """Vehicle of a recording that has to be opened to determine it."""
    from tierod.io.readers import open_chunks

    assert task.fleet is not None
    entry = task.fleet.entry(task.found.name)
    column = _first_of(path, entry.column) if entry.column else None
    metadata: Mapping[str, Any] = {}
    if entry.metadata or entry.cohort_metadata or entry.mileage_metadata:
        car = _loaded(entry.parameters) if entry.parameters else None
        dbc, channel_map = (car.database, car.channel_map) if car else (None, None)
        chunks = open_chunks(path, seconds=1.0, dbc=dbc, channel_map=channel_map)
        metadata = next(iter(chunks)).metadata
    return task.fleet.assigned(task.found.name, metadata, column)


def _first_of(path: Path, column: str) -> str | None:
    """The first text in a column of a Parquet file; None if it has none."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        file = pq.ParquetFile(native_file(path))
        if column not in file.schema_arrow.names:
            return None
        batch = next(file.iter_batches(64, columns=[column]), None)
    except pa.ArrowException:
        return None
    texts = [] if batch is None else [str(each) for each in batch[column].to_pylist() if each is not None]
    return texts[0] if texts else None


@cache
def _loaded(parameters: str) -> Vehicle:
    from tierod.vehicles import load

    return load(parameters)


def _judged(job: Job, path: Path, assigned: Assigned, row: dict[str, Any]) -> bytes:
    """Stored or new findings of a recording; the facts for the ledger are added to the row."""
    from tierod.monitors.acceptance import vehicle_named_in

    car = _loaded(assigned.parameters or vehicle_named_in(path))
    digest = vehicle_digest(car)
    key = fingerprint(row["recording"], digest, job.asked, job.code, assigned.start, job.with_levels)
    row["key"] = key
    kept = _kept(job.results, key)
    if kept is not None:
        row |= kept[0]
        return kept[1]
    runner = job.asked.runner(car)
    needs = dict.fromkeys([*runner.needs, TEMPERATURE])
    pieces = pieces_of(path, needs, car, seconds=chunk(job.asked)) if runner.runs else iter(())
    found = judge(pieces, runner, job.asked, assigned.start)
    if not found.rows:
        raise _NoMonitor(f"no monitor can judge it: {_reasons(found.refused)}")
    if found.start is not None and found.start > time.time() + FUTURE:
        raise _Future(f"by its clock it begins at {schema.shown_time(found.start)}, in the future; correct the clock")
    about = _about(found)
    content = _stream(found, row["recording"], key, digest, about)
    # The levels first: the part marks the result as complete.
    if job.with_levels:
        job.results.write(levels.path_of(key), levels.content_of(found.estimates))
    job.results.write(part_of(key), content)
    row |= about
    return content


def _reasons(refused: Mapping[str, str]) -> str:
    """Why each monitor did not run; each reason once, the one of most monitors first."""
    names: dict[str, list[str]] = {}
    for name, reason in refused.items():
        names.setdefault(reason, []).append(name)
    ordered = sorted(names.items(), key=lambda each: -len(each[1]))
    return "; ".join(f"{', '.join(each)}: {reason}" for reason, each in ordered)


def _about(found: Judgement) -> dict[str, Any]:
    return {
        "start": found.start,
        "duration_s": found.duration,
        "findings": len(found.rows),
        "remarks": [f"{name} did not run: {reason}" for name, reason in found.refused.items()],
        "moments": found.moments,
    }


def part_of(key: str) -> str:
    """Path of a result in the results folder."""
    return f"parts/{key[:2]}/{key}.arrow"


def _stream(found: Judgement, recording: str, key: str, vehicle: str, about: Mapping[str, Any]) -> bytes:
    import pyarrow as pa

    common = {"recording": recording, "key": key, "vehicle_digest": vehicle}
    whole = schema.findings()
    table = schema.table_of("findings", [row | common for row in found.rows])
    metadata = {**whole.metadata, b"tierod.about": json.dumps(about).encode()}
    buffer = io.BytesIO()
    with pa.ipc.new_file(buffer, whole.with_metadata(metadata)) as out:
        out.write_table(table)
    return buffer.getvalue()


def _kept(results: Place, key: str) -> tuple[dict[str, Any], bytes] | None:
    """Facts for the ledger and content of a stored result; None if there is no complete one."""
    import pyarrow as pa

    try:
        content = results.read(part_of(key))
        with pa.ipc.open_file(io.BytesIO(content)) as file:
            return json.loads(file.schema.metadata[b"tierod.about"]), content
    except (OSError, pa.ArrowException, KeyError, ValueError):
        return None


def table_of(content: bytes | IO[bytes]) -> pa.Table:
    """Findings of a stored result."""
    import pyarrow as pa

    with contextlib.suppress(pa.ArrowException, OSError):
        source = io.BytesIO(content) if isinstance(content, bytes) else content
        with pa.ipc.open_file(source) as file:
            return file.read_all().replace_schema_metadata(schema.findings().metadata)
    raise InputError("a result is damaged; delete it and run again")
