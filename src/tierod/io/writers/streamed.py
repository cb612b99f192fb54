"""Writing a recording that comes in pieces, so that ten hours take no more memory than ten minutes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.arrow import column_of
from tierod.core.errors import OutputError
from tierod.core.files import replacing
from tierod.core.recording import Recording
from tierod.io.writers import WRITERS, require_writable, write
from tierod.io.writers.mat import write_mat
from tierod.io.writers.mcap import write_mcap
from tierod.io.writers.parquet import SLICE
from tierod.io.writers.spool import ROWS, Spool, SpooledGroup

_MOST = 100_000
"""Row groups of a Parquet file at the most."""


def write_pieces(pieces: Iterable[Recording], path: str | Path) -> tuple[str, ...]:
    """Write a recording piece by piece; every channel keeps its own time stamps, and its unit, source and note.

    Args:
        pieces: that follow each other; a channel may be missing in some of them
        path: as of `tierod.io.writers.write`

    Returns:
        what the format cannot hold, in sentences

    Raises:
        OutputError: as of `write`, or the temporary folder is full
        MissingExtra: the library for this format is not installed
    """
    require_writable(path)
    stream = _STREAMED.get(Path(path).suffix.lower())
    spool = Spool()
    for piece in pieces:
        spool.add(piece)
    if stream is not None:
        return stream(spool, path)
    found = spool.groups()
    channels = []
    for group in found:
        time, values = group.time(0, group.count), group.values(0, group.count)
        for channel, part in zip(group.channels, values, strict=True):
            channels.append(type(channel)(channel.name, time, part, channel.unit, channel.source, channel.note))
    write(Recording({each.name: each for each in channels}, spool.metadata), path)
    title = WRITERS[Path(path).suffix.lower().removeprefix(".")].title
    return (f"{title} is written by another package, which says what it holds",)


def _parquet(spool: Spool, path: str | Path) -> tuple[str, ...]:
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
            pq.ParquetWriter(temporary, schema, use_dictionary=False, write_page_checksum=True) as writer,
        ):
            for rows in _slices(found):
                length = max(last - first for first, last in rows)
                parts = []
                for group, (first, last) in zip(found, rows, strict=True):
                    parts += [column_of(each, length) for each in (group.time(first, last), *group.values(first, last))]
                writer.write_table(pa.table(parts, schema=schema), row_group_size=1 << 26)
    except pa.ArrowException as error:
        raise OutputError(f"{path} cannot be written: {' '.join(str(error).split())[:160]}") from None
    return ()


def _slices(found: tuple[SpooledGroup, ...]) -> Iterator[list[tuple[int, int]]]:
    """Per row group the (first, last) rows of every group, over equal slices of time."""
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


def _csv(spool: Spool, path: str | Path) -> tuple[str, ...]:
    import pyarrow as pa
    import pyarrow.csv as text

    found = spool.groups()
    about = spool.description(found)
    titles = [
        title for group in found for title in (f"{group.clock} [s]", *(_title(c.name, c.unit) for c in group.channels))
    ]
    names = {_title(each.name, each.unit): each.name for each in spool.channels.values()}
    about["channels"] = {title: about["channels"][name] | {"name": name} for title, name in names.items()}
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(f"# tierod {json.dumps(about)}\n".encode())
        file.write((",".join(_quoted(title) for title in titles) + "\n").encode())
        for begin in range(0, max(group.count for group in found), ROWS):
            counts = [min(max(group.count - begin, 0), ROWS) for group in found]
            parts: list[Any] = []
            for group, count in zip(found, counts, strict=True):
                columns = (group.time(begin, begin + count), *group.values(begin, begin + count))
                parts += [column_of(each, max(counts)) for each in columns]
            table = pa.table(parts, names=[str(place) for place in range(len(parts))])
            text.write_csv(table, file, text.WriteOptions(include_header=False))
        file.flush()
    return ()


def _title(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _quoted(title: str) -> str:
    escaped = title.replace('"', '""')
    return f'"{escaped}"' if any(sign in title for sign in ',"\n\r;\t') else title


def _mf4(spool: Spool, path: str | Path) -> tuple[str, ...]:
    import datetime
    import warnings

    from asammdf import MDF, Signal

    from tierod.io.writers.mf4 import header_comment, signal_comment

    found = spool.groups()
    about = spool.description(found)
    with replacing(path) as temporary, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = MDF(version="4.10")
        file.header.start_time = datetime.datetime.fromtimestamp(about["origin"], datetime.UTC)
        file.header.comment = header_comment(about["metadata"])
        try:
            for number, group in enumerate(found):
                for place, (time, values) in enumerate(group.rows()):
                    if place:
                        file.extend(number, [(time, None), *((part, None) for part in values)])
                        continue
                    signals = [
                        Signal(part, time, unit=each.unit, name=each.name, comment=signal_comment(each))
                        for each, part in zip(group.channels, values, strict=True)
                    ]
                    file.append(signals, acq_name=f"group {number}", comment="tierod", common_timebase=True)
            saved = Path(file.save(temporary, overwrite=True))
            if saved != temporary:
                saved.replace(temporary)
        finally:
            file.close()
    return ()


_STREAMED: dict[str, Callable[[Spool, str | Path], tuple[str, ...]]] = {
    ".parquet": _parquet,
    ".pq": _parquet,
    ".csv": _csv,
    ".mf4": _mf4,
    ".mcap": write_mcap,
    ".mat": write_mat,
}
"""Writers that take a recording piece by piece, by the ending of the file."""
