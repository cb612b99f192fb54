"""Logs of frames in memory, and all frames of a log at once."""

from collections.abc import Iterable
from pathlib import Path

from tierod.io.readers.content import Content, content_of
from tierod.io.readers.frames import Frames, Log, joined


def log_of(*blocks: Frames) -> Log:
    """A log that holds these frames."""
    return Log("some.log", lambda: [iter(blocks)])


def together(blocks: Iterable[Frames]) -> Frames:
    """The frames of all blocks, with all notes."""
    return joined(list(blocks))


def stored(folder: Path, data: bytes, name: str = "some.log") -> Content:
    """Bytes as the content of a file."""
    path = folder / name
    path.write_bytes(data)
    return content_of(path, data[:2] == b"\x1f\x8b")
