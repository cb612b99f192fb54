"""Every case that ever failed, as small files of TOML: `corpus/*.toml`.

    [[case]]
    name = "units-in-towers"
    why = "pint worked out the power for ever"
    command = ["inspect", "{file}"]
    file = "drive.csv"
    text = "time [s],yaw_rate [m**9**9**9**9]\\n0,1\\n1,2\\n"
    expected = [3]                # exit codes that are right
    says = "unit"                 # stands in what it says, where the words matter

The content is `text`, in which `fill = { "@" = ["[", 1000] }` puts 1000 brackets for each @; `packed`, base64 of zlib;
or `made`, the name in `MADE`.
"""

from __future__ import annotations

import base64
import gzip
import os
import struct
import tomllib
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .fuzz import arguments
from .pool import Pool, Result

FOLDER = Path(__file__).parent / "corpus"


@dataclass(frozen=True)
class Kept:
    """A case that failed once."""

    name: str
    why: str
    command: tuple[str, ...]
    file: str
    expected: tuple[int, ...]
    text: str = ""
    fill: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    packed: str = ""
    made: str = ""
    says: str = ""
    encoding: str = "utf-8"
    slow: bool = False

    def write(self, path: Path) -> None:
        """Make the file."""
        if self.made:
            MADE[self.made](path)
        elif self.packed:
            path.write_bytes(zlib.decompress(base64.b64decode(self.packed)))
        else:
            text = self.text
            for mark, (part, times) in self.fill.items():
                text = text.replace(mark, part * times)
            path.write_bytes(text.encode("utf-8", "surrogateescape"))

    def run(self, pool: Pool) -> Result:
        """Run the case."""
        folder = pool.folder()
        self.write(folder / self.file)
        return pool.run(arguments(self.command, folder, self.file), self.encoding)

    def fault(self, result: Result) -> str:
        """What is wrong with a result; "" where it is as it should be."""
        if result.kind:
            return f"{result.kind}: {result.detail}"
        if result.code not in self.expected:
            return f"exit {result.code}, expected {self.expected}: {result.stderr}"
        if self.says and self.says not in result.stdout + result.stderr:
            return f"does not say '{self.says}': {result.stderr}"
        return ""


def load() -> list[Kept]:
    """All cases of the corpus."""
    found = []
    for path in sorted(FOLDER.glob("*.toml")):
        for entry in tomllib.loads(path.read_text(encoding="utf-8"))["case"]:
            lists = {key: tuple(entry[key]) for key in ("command", "expected")}
            found.append(Kept(**{**entry, **lists}))
    return found


UNFOLDED = 3_600_000_000
"""To which a bomb unfolds [bytes]."""

_CHUNK = 1 << 24


def pipe(path: Path) -> None:
    """A pipe into which nothing is ever written."""
    os.mkfifo(path)


def device(path: Path) -> None:
    """A link to a device that never ends."""
    path.symlink_to("/dev/zero")


def a_folder(path: Path) -> None:
    """A a_folder in place of a file."""
    path.mkdir()


def loop(path: Path) -> None:
    """A link to itself."""
    path.symlink_to(path)


def large_text(path: Path) -> None:
    """A hundred megabytes of comments above a vehicle."""
    with path.open("wb") as file:
        for _ in range(100):
            file.write((b"#" + b" " * 62 + b"\n") * (1 << 14))
        file.write(b'name = "mine"\n')


def gzip_bomb(path: Path) -> None:
    """A table of two columns, packed in members that are all alike."""
    member = gzip.compress(b"0.01,0.02\n" * (_CHUNK // 10), mtime=0)
    head = gzip.compress(b"time [s],yaw_rate [rad/s]\n", mtime=0)
    path.write_bytes(head + member * (UNFOLDED // _CHUNK))


def mat_bomb(path: Path) -> None:
    """A vector beside its time, each packed; the numbers are all zero."""
    count = UNFOLDED // 16
    elements = b"".join(_mat_vector(name, count) for name in ("t", "yaw_rate"))
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49) + elements)


def _mat_vector(name: str, count: int) -> bytes:
    label = name.encode().ljust(8, b"\0")
    head = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIII", 5, 8, count, 1)
    head += struct.pack("<II", 1, len(name)) + label + struct.pack("<II", 9, 8 * count)
    total = 56 + 8 * count
    inner = struct.pack("<II", 14, total - 8) + head
    packed = _zeros(inner, 8 * count)
    return struct.pack("<II", 15, len(packed)) + packed


def _zeros(head: bytes, count: int) -> bytes:
    """A zlib stream of some bytes and many zeros, from one packed chunk of them."""
    first = zlib.compressobj(9, wbits=-15)
    begin = first.compress(head) + first.flush(zlib.Z_FULL_FLUSH)
    packer = zlib.compressobj(9, wbits=-15)
    chunk = packer.compress(bytes(_CHUNK)) + packer.flush(zlib.Z_FULL_FLUSH)
    rest = zlib.compressobj(9, wbits=-15)
    end = rest.compress(bytes(count % _CHUNK)) + rest.flush()
    a = zlib.adler32(head)
    low, high = a & 0xFFFF, a >> 16
    checksum = ((high + low * count) % 65521) << 16 | low
    return b"\x78\xda" + begin + chunk * (count // _CHUNK) + end + checksum.to_bytes(4, "big")


def blf_bomb(path: Path) -> None:
    """Containers that hold one object of four gigabytes, each part packed to a thousandth."""
    size = 1 << 26
    packed = _zeros(struct.pack("<4sHHII", b"LOBJ", 32, 1, 0xFFFFFFF0, 999), size - 16)
    head = struct.pack("<4sHHII", b"LOBJ", 16, 1, 32 + len(packed), 10) + struct.pack("<H6xI4x", 2, size)
    container = head + packed + bytes(len(packed) % 4)  # as python-can pads
    containers = container * (UNFOLDED // size)
    header = struct.pack(
        "<4sIBBBBBBBBQQII", b"LOGG", 144, 5, 0, 0, 0, 2, 6, 8, 1, 144 + len(containers), UNFOLDED, 0, 0
    )
    path.write_bytes(header.ljust(144, b"\0") + containers)


MADE = {
    "pipe": pipe, "device": device, "folder": a_folder, "loop": loop, "large_text": large_text, "gzip_bomb": gzip_bomb,
    "mat_bomb": mat_bomb, "blf_bomb": blf_bomb,
}  # fmt: skip
"""What makes the file of a case, by name."""
