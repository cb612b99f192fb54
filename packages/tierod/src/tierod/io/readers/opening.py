"""Opening of files: the format, by the content first and the ending second, and the databases of a CAN log."""

from __future__ import annotations

import os
import stat
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO

from tierod.core.errors import InputError, PluginWarning, TierodError, nearest
from tierod.core.plugins import Registry
from tierod.io.readers.channel_map import GUESSED, TimeEntry, maps_beside
from tierod.io.readers.content import Content, content_of, spooled
from tierod.io.readers.frames import Heard, Log, heard, identifier_text
from tierod.io.readers.source import Format, Lane, Source


def holds_bag(folder: Path) -> bool:
    return (folder / "metadata.yaml").is_file() and bool(bag_files(folder))


def bag_files(folder: Path) -> list[Path]:
    return sorted(each for each in folder.iterdir() if each.suffix in (".db3", ".mcap"))


def beside_bag(folder: Path, endings: Iterable[str]) -> str:
    """A sentence on recordings in the folder of a bag that are no part of it; "" where there are none."""
    known = set(endings)
    own = set(bag_files(folder))
    others = [each.name for each in sorted(folder.iterdir()) if each.suffix.lower() in known and each not in own]
    if not others:
        return ""
    more = f" and {len(others) - 3} more" if len(others) > 3 else ""
    return f"the folder is a ROS 2 bag; {', '.join(others[:3])}{more} beside it was not read: give it by its own path"


def folder_content(folder: Path) -> Content:
    """The content of a folder, which only the reader of bags can open."""

    def opened() -> IO[bytes]:
        raise InputError(f"{folder} is a folder; give one recording in it")

    return Content(folder, sum(each.stat().st_size for each in bag_files(folder)), False, False, opened)


_HEAD = 1 << 16

_REFUSED = (
    (b"PK\x03\x04", "is a ZIP archive or a spreadsheet; unpack it, or export the sheet as CSV"),
    (b"%PDF", "is a PDF document; give the recording itself"),
    (b"<?xml", "is an XML document; give the recording itself"),
    (b"\x7fELF", "is a program; give the recording itself"),
)

# tierod's own formats, in the order in which they examine the beginning of a file; the last takes any other text
_OWN = {
    "parquet": "tierod.io.readers.tables:PARQUET",
    "mdf": "tierod.io.readers.mdf:FORMAT",
    "mat": "tierod.io.readers.vectors:MAT",
    "hdf5": "tierod.io.readers.vectors:HDF5",
    "arrow": "tierod.io.readers.tables:ARROW",
    "mcap": "tierod.io.readers.bags:MCAP",
    "ros1": "tierod.io.readers.bags:ROS1",
    "ros2": "tierod.io.readers.bags:ROS2",
    "erg": "tierod.io.readers.erg:FORMAT",
    "blf": "tierod.io.readers.vendor_can:BLF",
    "asc": "tierod.io.readers.asc:FORMAT",
    "trc": "tierod.io.readers.vendor_can:TRC",
    "candump": "tierod.io.readers.candump:FORMAT",
    "json": "tierod.io.readers.records:JSON",
    "long-csv": "tierod.io.readers.records:LONG",
    "can-csv": "tierod.io.readers.can_csv:FORMAT",
    "csv": "tierod.io.readers.csv:FORMAT",
}

_FALLBACK = "csv"
_ALSO_TEXT = ("candump", "can-csv", "long-csv")  # formats that also have the endings of the fallback


def _obstacle(name: str, given: object) -> str:
    """Reason why an object that a package registers cannot read files; "" where it can."""
    if not isinstance(given, Format):
        return f"is of the type '{type(given).__name__}'; expected a tierod.io.readers.Format"
    return "" if given.name == name else f"calls itself '{given.name}'; register it under that name"


# Every file format by its name, tierod's own and those of installed packages
READERS: Registry[Format] = Registry("tierod.readers", "reader", _OWN, _obstacle)


@dataclass(frozen=True)
class Kind:
    format: Format  # format of the file, whose reader opens it
    content: Content  # its bytes
    warning: str = ""  # warning where the ending is that of another format; else ""

    @property
    def name(self) -> str:
        return self.format.name


def detect(path: Path) -> Kind:
    """The kind of a file, from its content first and its ending second."""
    if os.path.isdir(path) and holds_bag(path):
        endings = {ending for each in READERS.values() for ending in each.endings} - {".csv", ".txt", ".log"}
        return Kind(READERS["ros2"], folder_content(path), beside_bag(path, endings))
    content = _content(path)
    if content.packed:
        path = path.with_suffix("")
    head = content.head(_HEAD)
    if not head.strip(b"\0 \t\r\n\xef\xbb\xbf"):
        raise InputError(f"{content.path} is empty; record or copy it again")
    found = _recognised(path, head)
    promised = _promised(path)
    warning = ""
    if promised and promised != found.name and (promised != _FALLBACK or found.name not in _ALSO_TEXT):
        warning = (
            f"the ending {path.suffix} belongs to {promised}, but the content is {found.name} and was read as such"
        )
    return Kind(found, content, warning)


def _content(path: Path) -> Content:
    try:
        if not path.is_dir() and (stat.S_ISCHR(mode := path.stat().st_mode) or stat.S_ISBLK(mode)):
            raise InputError(f"{path} is a device; give a recording, or /dev/stdin with one piped into it")
        with path.open("rb") as file:
            if stat.S_ISFIFO(os.fstat(file.fileno()).st_mode):
                return spooled(path, file)
            return content_of(path, file.read(2) == b"\x1f\x8b")
    except FileNotFoundError:
        raise _absent(path) from None
    except IsADirectoryError:
        raise InputError(f"{path} is a folder; give one recording in it") from None
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror or error}); check its permissions") from None


def require_there(path: Path) -> None:
    """Refuse the path of an absent file without opening one."""
    if not os.path.exists(path):
        raise _absent(path)


def _absent(path: Path) -> InputError:
    other = "to read from a pipe, give /dev/stdin" if str(path) == "-" else "check the path"
    return InputError(f"there is no file {path}; {other}")


def _recognised(path: Path, head: bytes) -> Format:
    """The format of a file: by its beginning, else by its ending where it is text."""
    ending = path.suffix.lower()
    # One after the other, so that the modules of the formats behind the one that is found are not imported.
    for each in map(READERS.__getitem__, READERS.own):
        if each.recognises(head, ending):
            return each
    promised = _promised(path)
    readable = b"\0" not in head or head[:2] in (b"\xff\xfe", b"\xfe\xff")
    refusal = next((sentence for beginning, sentence in _REFUSED if head.startswith(beginning)), "")
    if promised and READERS[promised].text and readable and not refusal:
        return READERS[promised]
    # Installed packages are searched only here, so that a usual recording does not wait for that.
    for name in READERS.plugin_names():
        if _asked(READERS[name], READERS.package_of(name), head, ending):
            return READERS[name]
    if refusal:
        raise InputError(f"{path} {refusal}")
    if readable:
        return READERS[_FALLBACK]
    if promised:
        raise InputError(f"{path} is not a {promised} file, or its beginning is damaged; copy or export it again")
    kinds = ", ".join(each.title for each in map(READERS.__getitem__, READERS.own) if each.endings)
    raise InputError(f"{path} has no known format; give one of these: {kinds}")


def _asked(plugin: Format, package: str, head: bytes, ending: str) -> bool:
    try:
        return bool(plugin.recognises(head, ending))
    except Exception as error:
        warnings.warn(
            f"the reader '{plugin.name}' of the package {package} fails to look at a file "
            f"({type(error).__name__}: {' '.join(str(error).split())[:120]}) and is left out; update or uninstall it",
            PluginWarning,
            stacklevel=2,
        )
        return False


def _promised(path: Path) -> str:
    ending = path.suffix.lower()
    return next((name for name in READERS.own if ending in READERS[name].endings), "")


Paths = str | Path | Sequence[str | Path] | None


def open_source(path: str | Path, dbc: Paths = None, time: TimeEntry | None = None) -> tuple[Source, Kind]:
    """The columns of a file, and its kind; nothing is loaded that the listing does not need."""
    path = Path(path)
    if os.path.isdir(path) and not holds_bag(path):
        return _joined(path, dbc, time)
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


def frames_in(path: Path) -> Log | None:
    """The frames of a file that is a bus log; None where it holds channels."""
    if os.path.isdir(path):
        return None
    kind = detect(path)
    opened = _opened(kind, GUESSED)
    return opened if isinstance(opened, Log) else None


def open_parts(paths: Sequence[Path], dbc: Paths = None, time: TimeEntry | None = None) -> tuple[Source, Kind]:
    """Several files of one drive as one, in the order of their time; arguments and errors as for `open_source`."""
    from tierod.io.readers.slices import joined_source

    opened = [(path, *open_source(path, dbc, time)) for path in paths]
    if len(opened) == 1:
        return opened[0][1:]
    return joined_source([(path, source) for path, source, _ in opened]), opened[0][2]


def _joined(folder: Path, dbc: Paths, time: TimeEntry | None) -> tuple[Source, Kind]:
    from tierod.io.readers.slices import parts_in

    endings = [ending for name in READERS.own for ending in READERS[name].endings]
    return open_parts(parts_in(folder, endings), dbc, time)


def _opened(kind: Kind, time: TimeEntry) -> Source | Log:
    """The opened file; an error in the reader of another package becomes an InputError that names the package."""
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
            "a DBC file defines their signals: give it with dbc= (--dbc), or name it in the vehicle file "
            "(dbc under [channels])"
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
        # Errors of unpacking name the path already.
        raise InputError(str(error) if str(path) in str(error) else f"{path}: {error}") from None


def shipped(name: str | Path, ending: str) -> Path:
    """The path of a file as given, or of the shipped one for a bare name, even beside a folder of that name."""
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
