"""Writing recordings: one function for every format, chosen by the ending of the file."""

from __future__ import annotations

from pathlib import Path

from tierod.errors import OutputError, nearest
from tierod.recording import Recording

__all__ = ["write"]

_ENDINGS = (".parquet", ".pq", ".csv", ".mf4")


def write(recording: Recording, path: str | Path) -> None:
    """Write a recording; every channel keeps its own time stamps, its unit, source and note.

    Args:
        recording: with at least one channel
        path: ends in .parquet, .csv or .mf4; the file appears whole or not at all

    Raises:
        OutputError: an ending that is not known, nothing to write, no such folder, no permission, disk full
        MissingExtra: the library for this format is not installed
    """
    ending = Path(path).suffix.lower()
    if ending in (".parquet", ".pq"):
        from tierod.writers.parquet import write_parquet

        write_parquet(recording, path)
    elif ending == ".csv":
        from tierod.writers.csv import write_csv

        write_csv(recording, path)
    elif ending == ".mf4":
        from tierod.writers.mf4 import write_mf4

        write_mf4(recording, path)
    else:
        raise OutputError(f"{path} has no ending that can be written{nearest(ending, _ENDINGS)}")
