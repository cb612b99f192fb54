"""What kind of file it is: by its content first, by its ending second."""

from __future__ import annotations

import os
import re
import stat
from dataclasses import dataclass
from pathlib import Path

from tierod.core.errors import InputError
from tierod.io.readers.candump import LINE
from tierod.io.readers.content import Content, content_of, spooled

_HEAD = 1 << 16

_MAGIC = (
    (b"MDF ", "mdf"),
    (b"UnFinMF ", "mdf"),
    (b"PAR1", "parquet"),
    (b"MATLAB 5.0", "mat"),
    (b"LOGG", "blf"),
)

_REFUSED = (
    (
        b"#ROSBAG",
        "is a ROS 1 bag, which is not read yet; convert its topics to Parquet or CSV (rosbags-convert, PlotJuggler)",
    ),
    (
        b"SQLite format 3",
        "is a database, probably a ROS 2 bag, which is not read yet; export its topics to Parquet or CSV",
    ),
    (b"\x89MCAP", "is an MCAP file, which is not read yet; export its topics to Parquet or CSV"),
    (b"\x89HDF", "is an HDF5 file; if MATLAB wrote it, save it with -v7, else export it to Parquet or CSV"),
    (b"MATLAB 7.3", "is a MATLAB 7.3 file; save it with -v7"),
    (b"PK\x03\x04", "is a ZIP archive or a spreadsheet; unpack it, or export the sheet as CSV"),
    (b"%PDF", "is a PDF document; give the recording itself"),
    (b"<?xml", "is an XML document; give the recording itself"),
    (b"\x7fELF", "is a program; give the recording itself"),
)

_ENDINGS = {
    ".mf4": "mdf", ".mdf": "mdf", ".dat": "mdf", ".parquet": "parquet", ".pq": "parquet", ".mat": "mat", ".blf": "blf",
    ".asc": "asc", ".trc": "trc", ".log": "candump", ".csv": "csv", ".txt": "csv", ".tsv": "csv",
}  # fmt: skip

_ASC = re.compile(rb"^\s*(//.*\s+)?(date .*\s+)?base\s+(hex|dec)\b", re.IGNORECASE)
_TRC = re.compile(rb"^;(\$FILEVERSION|#{10})|^;.*PCAN", re.IGNORECASE)


@dataclass(frozen=True)
class Kind:
    """What a file is.

    Args:
        name: "mdf", "parquet", "mat", "blf", "asc", "trc", "candump" or "csv"
        content: its bytes
        warning: what the ending promised otherwise
    """

    name: str
    content: Content
    warning: str = ""


def detect(path: Path) -> Kind:
    """The kind of a file.

    Raises:
        InputError: the file is absent, empty, not readable, or of a kind that is not read
    """
    content = _content(path)
    if content.packed:
        path = path.with_suffix("")
    head = content.head(_HEAD)
    if not head.strip(b"\0 \t\r\n\xef\xbb\xbf"):
        raise InputError(f"{content.path} is empty; record or copy it again")
    name = _by_content(path, head)
    promised = _ENDINGS.get(path.suffix.lower())
    warning = ""
    if promised and promised != name and not (promised == "csv" and name == "candump"):
        warning = f"the ending {path.suffix} promises {promised}, the content is {name} and was read as such"
    return Kind(name, content, warning)


def _content(path: Path) -> Content:
    """The bytes of a file; those of a pipe are kept."""
    try:
        if not path.is_dir() and (stat.S_ISCHR(mode := path.stat().st_mode) or stat.S_ISBLK(mode)):
            raise InputError(f"{path} is a device; give a recording, or /dev/stdin with one piped into it")
        with path.open("rb") as file:
            if stat.S_ISFIFO(os.fstat(file.fileno()).st_mode):
                return spooled(path, file)
            return content_of(path, file.read(2) == b"\x1f\x8b")
    except FileNotFoundError:
        other = "; what comes through a pipe is named /dev/stdin" if str(path) == "-" else "; check the path"
        raise InputError(f"there is no file {path}{other}") from None
    except IsADirectoryError:
        raise InputError(f"{path} is a folder; give one recording in it") from None
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror or error}); check the rights") from None


def _by_content(path: Path, head: bytes) -> str:
    for magic, name in _MAGIC:
        if head.startswith(magic):
            return name
    for magic, sentence in _REFUSED:
        if head.startswith(magic):
            raise InputError(f"{path} {sentence}")
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    if _ASC.match(text):
        return "asc"
    if _TRC.match(text):
        return "trc"
    if LINE.search(text):
        return "candump"
    if b"\0" in head and head[:2] not in (b"\xff\xfe", b"\xfe\xff"):
        raise InputError(_binary(path))
    promised = _ENDINGS.get(path.suffix.lower())
    return promised if promised in ("asc", "trc", "candump") else "csv"


def _binary(path: Path) -> str:
    promised = _ENDINGS.get(path.suffix.lower())
    if promised:
        return f"{path} is no {promised} file or its beginning is damaged; copy or export it again"
    return f"{path} is of no known kind; give an MF4, Parquet, CSV, MATLAB, candump, ASC, BLF or TRC file"
