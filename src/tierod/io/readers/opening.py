"""Opening a file: which reader its content needs, and the database that a CAN log needs besides."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from tierod.core.errors import InputError, TierodError, nearest
from tierod.io.readers.channel_map import GUESSED, TimeEntry, maps_beside
from tierod.io.readers.formats import READERS, Kind, detect
from tierod.io.readers.frames import identifier_text
from tierod.io.readers.log import Heard, Log, heard
from tierod.io.readers.source import Lane, Source

Paths = str | Path | Sequence[str | Path] | None


def open_source(path: str | Path, dbc: Paths = None, time: TimeEntry | None = None) -> tuple[Source, Kind]:
    """The columns of a file, and what kind of file it is; nothing is loaded that the listing does not need.

    Args:
        path: of the file
        dbc: databases of a CAN log
        time: which column of a table is the time, and in which unit; MDF files and CAN logs define their time

    Raises:
        InputError: the file or the database cannot be used
        MissingExtra: the library for this format is not installed
    """
    path = Path(path)
    kind = detect(path)
    if kind.format.whole and kind.content.piped:
        raise InputError(f"{path} is a pipe, through which only text and CAN logs can come; give the file itself")
    if kind.format.whole and kind.content.packed:
        raise InputError(f"{path} is packed, which only text and CAN logs may be; unpack it first: gunzip -k {path}")
    opened = _opened(kind, time or GUESSED)
    if isinstance(opened, Source):
        for entry in [dbc] if isinstance(dbc, str | Path) else dbc or ():
            if not shipped(entry, ".dbc").is_file():
                raise InputError(f"there is no CAN database {entry}; check the path, or leave it out for this file")
        return replace(opened, size=kind.content.size), kind
    return replace(_decoded(path, opened, dbc, kind), size=kind.content.size), kind


def _opened(kind: Kind, time: TimeEntry) -> Source | Log:
    """The file as its reader opens it; what fails in that of another package is a sentence about that package."""
    if kind.name in READERS.own:
        return kind.format.open(kind.content, time)
    with _blaming(kind):
        opened = kind.format.open(kind.content, time)
    if isinstance(opened, Log):
        return opened
    return replace(opened, lanes=lambda names: [_watched(kind, lane) for lane in opened.lanes(names)])


def _watched(kind: Kind, lane: Lane) -> Lane:
    with _blaming(kind):
        yield from lane


@contextmanager
def _blaming(kind: Kind) -> Iterator[None]:
    try:
        yield
    except TierodError:
        raise
    except Exception as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(
            f"{kind.content.path} cannot be read by the reader '{kind.name}' of the package "
            f"{READERS.package_of(kind.name)} ({type(error).__name__}: {reason}); update that package, or export the "
            "file in another format"
        ) from error


def _decoded(path: Path, log: Log, dbc: Paths, kind: Kind) -> Source:
    from tierod.io.readers.dbc import bus_source, load_databases

    if dbc is None or (not isinstance(dbc, str | Path) and not dbc):
        heard = _heard(path, log)
        ids = sorted({identifier for _, identifier in heard.counts})
        some = ", ".join(identifier_text(identifier) for identifier in ids[:6]) + ", ..." * (len(ids) > 6)
        raise InputError(
            f"{path} holds {heard.frames} CAN frames of {len(ids)} identifiers ({some}); "
            "which signals they carry stands in a DBC file: give it with dbc= (--dbc)"
        )
    paths = [dbc] if isinstance(dbc, str | Path) else list(dbc)
    found = [shipped(entry, ".dbc") for entry in paths]
    database = load_databases(found)
    names = {"format": kind.name, "dbc": tuple(str(entry) for entry in paths)}
    return replace(bus_source(log, _heard(path, log), database, names), maps=maps_beside(found))


def _heard(path: Path, log: Log) -> Heard:
    try:
        return heard(log)
    except InputError as error:
        # The packed file and its limits name it themselves.
        raise InputError(str(error) if str(path) in str(error) else f"{path}: {error}") from None


def shipped(name: str | Path, ending: str) -> Path:
    """A file as given, or the one that tierod ships where a bare name is given; a folder of that name is no file."""
    path = Path(name)
    if path.is_file() or path.suffix or len(path.parts) > 1:
        return path
    folder = Path(__file__).resolve().parents[2] / "vehicles"
    shipped = {file.name.removesuffix(ending): file for file in folder.glob(f"*{ending}")}
    if path.name not in shipped:
        raise InputError(
            f"there is no file {path}, and tierod ships no '{path.name}{ending}'{nearest(path.name, shipped)}"
        )
    return shipped[path.name]
