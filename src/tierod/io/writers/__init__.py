"""Writing recordings: one function for every format, chosen by the ending of the file."""

from __future__ import annotations

from pathlib import Path

from tierod.core.errors import OutputError, nearest
from tierod.core.files import expanded
from tierod.core.recording import Recording

__all__ = ["require_writable", "write"]

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
    ending = _ending(path)
    if ending in (".parquet", ".pq"):
        from tierod.io.writers.parquet import write_parquet

        write_parquet(recording, path)
    elif ending == ".csv":
        from tierod.io.writers.csv import write_csv

        write_csv(recording, path)
    else:
        from tierod.io.writers.mf4 import write_mf4

        write_mf4(recording, path)


def require_writable(path: str | Path) -> None:
    """What `write` would complain about after a long run, now: ending, folder, library.

    Args:
        path: as for `write`

    Raises:
        OutputError: an ending that is not known, no such folder, or a folder of that name
        MissingExtra: the library for this format is not installed
    """
    path = expanded(path)
    if _ending(path) == ".mf4":
        from tierod.io.writers.mf4 import require_asammdf

        require_asammdf()
    if not path.parent.is_dir():
        raise OutputError(f"{path} cannot be written: there is no folder {path.parent}; create it first")
    if path.is_dir():
        raise OutputError(f"{path} cannot be written: it is a folder; name a file")


def _ending(path: str | Path) -> str:
    ending = Path(path).suffix.lower()
    if ending not in _ENDINGS:
        raise OutputError(f"{path} has no ending that can be written{nearest(ending, _ENDINGS)}")
    return ending
