"""WIM, a text format that exists for this example: "WIM 1", a line of names with units, then numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tierod import Channel, InputError, Recording
from tierod.io.readers import Content, Format, Source, TimeEntry, begins_with, source_of
from tierod.io.writers import Writer


def open_wim(content: Content, time: TimeEntry) -> Source:
    """The columns of a WIM file; the first is the time in seconds."""
    with content.stream() as stream:
        _, titles, *rows = stream.read().decode("utf-8").splitlines()
    columns = [title.removesuffix("]").partition(" [")[::2] for title in titles.split(";")]
    table = np.array([[float(cell) for cell in row.split(";")] for row in rows])
    if table.ndim != 2 or table.shape[1] != len(columns):
        raise InputError(f"{content.path} has rows that do not fit its titles; export it again")
    channels = [
        Channel(name, table[:, 0], values, unit) for (name, unit), values in zip(columns[1:], table.T[1:], strict=True)
    ]
    return source_of(channels, {"format": "WIM"})


def write_wim(recording: Recording, path: str | Path) -> None:
    """Write the channels of a recording on a common grid of 100 Hz."""
    grid = recording.align(recording.names, rate=100.0)
    titles = ";".join(["time [s]", *(f"{name} [{recording[name].unit}]" for name in grid.names)])
    rows = (";".join(map(repr, row)) for row in np.column_stack([grid.time, grid.values]).tolist())
    Path(path).write_text("\n".join(["WIM 1", titles, *rows]) + "\n", encoding="utf-8")


WIM = Format("wim", "WIM (.wim)", (".wim",), open_wim, begins_with(b"WIM 1\n"))

WIM_WRITER = Writer("WIM", write_wim)
