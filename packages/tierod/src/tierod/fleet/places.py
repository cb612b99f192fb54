"""Places of recordings and results: local folders, or storages that fsspec can access (s3://bucket/results).

A file of a `Place` is complete or absent: it is written under another name and renamed, or uploaded as one object.
"""

from __future__ import annotations

import contextlib
import os
import posixpath
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from tierod.core.errors import InputError, MissingExtra, OutputError
from tierod.core.files import expanded

LOCAL = "file"
"""Protocol of local folders."""


@dataclass(frozen=True)
class Place:
    """A folder given by its address; it is sent to workers as text and opens its storage there.

    Args:
        root: path of the folder, or its address with a protocol
    """

    root: str
    _opened: list[Any] = field(default_factory=list, compare=False, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        return {"root": self.root, "_opened": []}

    @property
    def local(self) -> bool:
        return protocol_of(self.root) == LOCAL

    @property
    def storage(self) -> Any:
        """The fsspec storage that contains the folder."""
        if not self._opened:
            self._opened.append(storage_of(self.root))
        return self._opened[0]

    def _address(self, path: str = "") -> str:
        base = str(self.storage._strip_protocol(self.root))
        return posixpath.join(base, path) if path else base

    def shown(self, path: str = "") -> str:
        """A path in the folder as messages name it."""
        return posixpath.join(self.root, path) if path else self.root

    def files(self, folder: str, ending: str) -> list[str]:
        """Paths of the files below a folder, sorted by name, without hidden files."""
        if self.local:
            top = Path(self.root)
            found = (path.relative_to(top).as_posix() for path in (top / folder).rglob(f"*{ending}"))
        else:
            with answering(self.root):
                base = self._address()
                names = self.storage.find(self._address(folder))
            found = (name[len(base) + 1 :] for name in names if name.endswith(ending))
        return sorted(path for path in found if not posixpath.basename(path).startswith("."))

    def exists(self, path: str) -> bool:
        """Whether a file or folder exists."""
        if self.local:
            return os.path.exists(os.path.join(self.root, path))
        with answering(self.root):
            return bool(self.storage.exists(self._address(path)))

    @contextmanager
    def open(self, path: str) -> Iterator[IO[bytes]]:
        """Open a file for reading."""
        if self.local:
            with open(os.path.join(self.root, path), "rb") as file:
                yield file
        else:
            with self.storage.open(self._address(path), "rb") as file:
                yield file

    def read(self, path: str) -> bytes:
        """The content of a file."""
        with self.open(path) as file:
            return file.read()

    def write(self, path: str, content: bytes, sync: bool = False) -> None:
        """Write a complete file, which replaces one of the same name."""
        try:
            if self.local:
                _write_local(Path(self.root, path), content, sync)
            else:
                self.storage.pipe_file(self._address(path), content)
        except Exception as error:
            if not isinstance(error, OSError) and not of_storage(error):
                raise
            raise OutputError(
                f"{self.shown(path)} cannot be written ({reason_of(error)}); make room, or check that the place can "
                "be reached and written, and run the same command again: what is finished is kept"
            ) from None

    def remove(self, path: str) -> None:
        """Remove a file if it exists."""
        with contextlib.suppress(OSError):
            if self.local:
                os.unlink(os.path.join(self.root, path))
            else:
                self.storage.rm_file(self._address(path))


@contextmanager
def answering(address: str) -> Iterator[None]:
    """Turn errors of a storage into one that states its address and the cause."""
    try:
        yield
    except Exception as error:
        if not isinstance(error, OSError) and not of_storage(error):
            raise
        raise InputError(
            f"{address} cannot be read ({reason_of(error)}); check the address, the access rights and the network"
        ) from None


def place_of(root: str | Path) -> Place:
    """The place of a folder; a local path is made absolute, since workers may run in another folder."""
    text = str(root)
    if protocol_of(text) == LOCAL:
        return Place(str(expanded(text.removeprefix("file://")).absolute()))
    return Place(text.rstrip("/"))


def protocol_of(address: str) -> str:
    """Protocol of an address, the part before "://"; `LOCAL` where there is none."""
    protocol, mark, _ = address.partition("://")
    return protocol if mark else LOCAL


def storage_of(address: str) -> Any:
    protocol = protocol_of(address)
    try:
        import fsspec

        return fsspec.filesystem(protocol)
    except ImportError as error:
        raise MissingExtra(error.name or "fsspec", "fleet", f"reading {protocol}:// addresses") from None
    except ValueError as error:
        raise InputError(f"{address} cannot be reached ({reason_of(error)}); known are paths and s3://") from None


def reason_of(error: BaseException) -> str:
    """Cause of an error, on one line."""
    text = (error.strerror if isinstance(error, OSError) else None) or str(error) or type(error).__name__
    return " ".join(text.split())[:200]


def of_storage(error: BaseException) -> bool:
    """Whether an error comes from the library of a storage, which may have error classes of its own."""
    return type(error).__module__.split(".")[0] in ("aiohttp", "botocore", "aiobotocore", "s3fs", "fsspec")


def _write_local(path: Path, content: bytes, sync: bool) -> None:
    temporary = path.with_name(f".{path.stem[:100]}.{secrets.token_hex(6)}{path.suffix}")
    try:
        try:
            handle = os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        except FileNotFoundError:
            path.parent.mkdir(parents=True, exist_ok=True)
            handle = os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            if sync:
                file.flush()
                os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise
