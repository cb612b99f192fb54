"""Writing of recordings: one function for every format, chosen by the ending of the file."""

from __future__ import annotations

from pathlib import Path

from tierod.core.errors import OutputError, nearest
from tierod.core.files import expanded
from tierod.core.plugins import Registry
from tierod.core.recording import Recording
from tierod.io.formats import Writer

__all__ = ["WRITERS", "Writer", "require_writable", "write"]

_OWN = {
    "parquet": "tierod.io.writers.tables:PARQUET",
    "pq": "tierod.io.writers.tables:PARQUET",
    "csv": "tierod.io.writers.tables:CSV",
    "mf4": "tierod.io.writers.measurements:MF4",
    "mcap": "tierod.io.writers.measurements:MCAP",
    "mat": "tierod.io.writers.tables:MAT",
}


def _obstacle(ending: str, given: object) -> str:
    """Reason why an object that a package registers cannot write files; "" where it can."""
    return "" if isinstance(given, Writer) else f"is of the type '{type(given).__name__}'; expected a tierod.io.Writer"


# Every format that can be written by the ending of its files, tierod's own and those of installed packages
WRITERS: Registry[Writer] = Registry("tierod.writers", "writer", _OWN, _obstacle)


def write(recording: Recording, path: str | Path) -> None:
    """Write a recording; every channel keeps its own time stamps, its unit, source and note.

    Args:
        recording: recording with at least one channel
        path: ends in .parquet, .csv, .mf4, .mcap, .mat, or an ending of a plug-in; the file appears whole or not at all

    Raises:
        OutputError: an ending that is not known, nothing to write, no such folder, no permission, disk full
        MissingExtra: the library for this format is not installed
    """
    _writer(path).write(recording, path)


def require_writable(path: str | Path) -> None:
    """Raise the errors of `write` before a long run instead of after it: ending, folder, library.

    Args:
        path: as for `write`

    Raises:
        OutputError: an ending that is not known, no such folder, or a folder of that name
        MissingExtra: the library for this format is not installed
    """
    path = expanded(path)
    if require := _writer(path).require:
        require()
    if not path.parent.is_dir():
        raise OutputError(f"{path} cannot be written: there is no folder {path.parent}; create it first")
    if path.is_dir():
        raise OutputError(f"{path} cannot be written: it is a folder; name a file")


def _writer(path: str | Path) -> Writer:
    ending = Path(path).suffix.lower()
    if ending.removeprefix(".") not in WRITERS:
        known = [f".{name}" for name in WRITERS]
        raise OutputError(f"{path} has no ending that can be written{nearest(ending, known)}")
    return WRITERS[ending.removeprefix(".")]
