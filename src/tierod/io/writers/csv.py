"""CSV: a comment line with sources and notes, titles with units, one time column per group of channels.

Groups with fewer samples end in empty cells. Numbers are written so that they read back to the last bit.
"""

from __future__ import annotations

import json
from pathlib import Path

from tierod.core.arrow import column_of
from tierod.core.errors import OutputError
from tierod.core.files import replacing
from tierod.core.recording import Recording
from tierod.io.layout import Group, Writer, description, groups


def write_csv(recording: Recording, path: str | Path) -> None:
    """Write a recording to a CSV file.

    Args:
        recording: with at least one channel
        path: the file; replaced as a whole

    Raises:
        OutputError: nothing to write, or the file cannot be written
    """
    import pyarrow as pa
    import pyarrow.csv as text

    found = groups(recording)
    titles = [title for group in found for title in _titles(group)]
    length = max(len(group.time) for group in found)
    columns = []
    for group in found:
        for values in (group.time, *(channel.values for channel in group.channels)):
            columns.append(column_of(values, length))
    table = pa.table(columns, names=[str(place) for place in range(len(columns))])
    about = description(recording, found)
    about["channels"] = {title: about["channels"][name] | {"name": name} for name, title in _named(found)}
    try:
        with replacing(path) as temporary, temporary.open("wb") as file:
            file.write(f"# tierod {json.dumps(about)}\n".encode())
            file.write((",".join(_quoted(title) for title in titles) + "\n").encode())
            text.write_csv(table, file, text.WriteOptions(include_header=False))
            file.flush()
    except pa.ArrowException as error:
        raise OutputError(f"{path} cannot be written: {' '.join(str(error).split())[:160]}") from None


def _titles(group: Group) -> list[str]:
    return [f"{group.clock} [s]", *(_title(channel.name, channel.unit) for channel in group.channels)]


def _title(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _named(found: tuple[Group, ...]) -> list[tuple[str, str]]:
    return [(channel.name, _title(channel.name, channel.unit)) for group in found for channel in group.channels]


def _quoted(title: str) -> str:
    escaped = title.replace('"', '""')
    return f'"{escaped}"' if any(sign in title for sign in ',"\n\r;\t') else title


WRITER = Writer("CSV", write_csv)
