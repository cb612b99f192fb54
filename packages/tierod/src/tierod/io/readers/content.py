"""The bytes of a file, unpacked where it is packed, within limits: some megabytes can hold gigabytes of zeros."""

from __future__ import annotations

import gzip
import io
import os
import re
import tempfile
import weakref
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Annotated, Any

from tierod.core.errors import InputError, ParameterError

# Environment variable that raises (or lowers) `Limits.largest`: a number of bytes, or one with kB, MB or GB
VARIABLE = "TIEROD_LARGEST"

_UNITS = {"": 1, "b": 1, "kb": 10**3, "mb": 10**6, "gb": 10**9, "kib": 2**10, "mib": 2**20, "gib": 2**30}


@dataclass(frozen=True)
class Limits:
    """Limits of the unpacked size of a recording, as text as well as in samples of eight bytes."""

    # unpacked size that any recording may have [byte]: ten hours at 100 Hz of 37 channels, as samples
    largest: Annotated[int, "byte"] = 10**9 + 10**8
    # largest ratio of unpacked to packed size beyond that; packed recordings of cars stay below 30, zeros reach
    # 1000
    ratio: Annotated[float, ""] = 100.0
    # size of one line of text [byte]: 10 000 columns of numbers with 16 digits take 0.2 MB
    line: Annotated[int, "byte"] = 1 << 22
    # size of one packed block that must be unpacked as a whole [byte]; recorders write 0.1 to 4 MB
    block: Annotated[int, "byte"] = 1 << 27


def limits() -> Limits:
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return Limits()
    match = re.fullmatch(r"(\d{1,15}(?:\.\d{1,6})?)\s*([a-zA-Z]{0,3})", text)
    if match is None or match[2].lower() not in _UNITS:
        raise ParameterError(f"{VARIABLE} = {text[:40]!r} is not a size; write bytes, or for example 4GB")
    size = int(float(match[1]) * _UNITS[match[2].lower()])
    return Limits(largest=size, block=max(size // 8, Limits.block))


class Allowance:
    """Counts the unpacked size of a file, and stops where it exceeds the limits."""

    def __init__(self, path: Path | str, size: int):
        self.path, self.size = path, size
        self.limits = limits()
        self.most = max(self.limits.largest, int(self.limits.ratio * size))
        self.taken = 0

    def take(self, count: int) -> None:
        self.taken += count
        if self.taken > self.most:
            raise self.refused(f"more than {self.most / 1e9:.3g} GB")

    def take_block(self, count: int) -> None:
        """Check the size of one packed block before it is unpacked."""
        if count > self.limits.block:
            raise self.refused(f"a block of {count / 1e9:.3g} GB, where {self.limits.block / 1e9:.3g} GB are the limit")

    def refused(self, what: str) -> InputError:
        return InputError(
            f"{self.path} takes {self.size / 1e6:.3g} MB and unpacks to {what}; if the file is intact, raise the "
            f"limit: set the environment variable {VARIABLE}, for example {VARIABLE}="
            f"{max(round(4e-9 * self.most), 4)}GB"
        )


BLOCK = 1 << 20  # Number of bytes of text that are read at a time


@dataclass(frozen=True)
class Content:
    path: Path  # path for messages
    size: int  # size of the stored file [bytes]
    packed: bool  # whether it is packed with gzip
    piped: bool  # whether it came through a pipe
    opened: Callable[[], IO[bytes]]  # opens the stored bytes, from the beginning

    def stream(self) -> IO[bytes]:
        return io.BufferedReader(_Unpacked(self)) if self.packed else self.opened()

    def blocks(self) -> Iterator[bytes]:
        with self.stream() as stream:
            while block := stream.read(BLOCK):
                yield block

    def head(self, count: int) -> bytes:
        with self.stream() as stream:
            return stream.read(count)


def content_of(path: Path, packed: bool) -> Content:
    return Content(path, path.stat().st_size, packed, False, lambda: path.open("rb"))


def spooled(path: Path, pipe: IO[bytes]) -> Content:
    """Content from a pipe, kept in a temporary file so that it can be read again."""
    allowance = Allowance(path, 0)
    kept, head = Kept(), b""
    try:
        while block := pipe.read(BLOCK):
            head = head or block[:2]
            allowance.take(len(block))
            kept.append(block)
    except OSError as error:
        raise InputError(f"{path} cannot be kept in a temporary file ({error.strerror or error}); make room") from None
    return Content(path, allowance.taken, head == b"\x1f\x8b", True, lambda: io.BufferedReader(_Again(kept)))


class Kept:
    """A temporary file without a name, which is removed with this object."""

    def __init__(self) -> None:
        # A bare descriptor for `pread`: several streams may read at once, since they share no position.
        with tempfile.TemporaryFile() as file:
            self.descriptor = os.dup(file.fileno())
        self.size = 0
        weakref.finalize(self, os.close, self.descriptor)

    def append(self, data: bytes) -> None:
        left = memoryview(data)
        while len(left):
            written = os.pwrite(self.descriptor, left, self.size)
            left, self.size = left[written:], self.size + written

    def read(self, count: int, at: int) -> bytes:
        """A number of bytes from a position on; fewer at the end."""
        return os.pread(self.descriptor, count, at)


class _Raw(io.RawIOBase):
    def readable(self) -> bool:
        return True


class Stream(_Raw):
    def __init__(self, blocks: Iterable[bytes]):
        self._blocks, self._rest = iter(blocks), memoryview(b"")

    def readinto(self, buffer: Any) -> int:
        while not len(self._rest):
            block = next(self._blocks, None)
            if block is None:
                return 0
            self._rest = memoryview(block)
        count = min(len(buffer), len(self._rest))
        buffer[:count] = self._rest[:count]
        self._rest = self._rest[count:]
        return count


class _Again(_Raw):
    def __init__(self, kept: Kept):
        self._kept, self._at = kept, 0

    def readinto(self, buffer: Any) -> int:
        data = self._kept.read(len(buffer), self._at)
        buffer[: len(data)] = data
        self._at += len(data)
        return len(data)


class _Unpacked(_Raw):
    def __init__(self, content: Content):
        self._content, self._file = content, content.opened()
        self._packed = gzip.GzipFile(fileobj=self._file)
        self._allowance = Allowance(content.path, content.size)

    def readinto(self, buffer: Any) -> int:
        try:
            data = self._packed.read(len(buffer))
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(
                f"{self._content.path} is damaged or cut off and cannot be unpacked ({error}); copy it again"
            ) from None
        self._allowance.take(len(data))
        buffer[: len(data)] = data
        return len(data)

    def close(self) -> None:
        self._packed.close()
        self._file.close()
        super().close()


def whole_lines(blocks: Iterable[bytes], path: Path | str, quotes: bool = False, end: bytes = b"\n") -> Iterator[bytes]:
    """Blocks of bytes cut again at the ends of lines, so that no line is in two of them."""
    most, rest = limits().line, b""
    for block in blocks:
        cut = _last_end(rest, block, quotes, end)
        if not cut:
            rest += block
            if len(rest) > most:
                why = "a quotation mark is not closed" if quotes else "it is not text"
                raise InputError(f"{path} holds a line of more than {most / 1e6:.3g} MB: {why}; export it again")
            continue
        yield rest + block[:cut]
        rest = block[cut:]
    if rest:
        yield rest


def _last_end(rest: bytes, block: bytes, quotes: bool, end: bytes) -> int:
    """The position after the last end of line in a block; 0 where there is none."""
    cut = block.rfind(end) + 1
    if not quotes:
        return cut
    marks = (rest.count(b'"') + block.count(b'"', 0, cut)) % 2
    # After an odd number of quotation marks the end of line is part of a cell.
    while cut and marks:
        before = block.rfind(end, 0, cut - 1) + 1
        marks = (marks + block.count(b'"', before, cut)) % 2
        cut = before
    return cut
