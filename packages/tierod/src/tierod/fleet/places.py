"""Places of recordings and results: local folders, or storages that fsspec can access (s3://bucket/results).

A file of a `Place` is complete or absent: it is written under another name and renamed, or uploaded as one object.
"""

from __future__ import annotations

import contextlib
import os
import posixpath
import re
import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from typing import IO, Any

from tierod.core.errors import InputError, MissingExtra, OutputError, ParameterError
from tierod.core.files import expanded, text_of

LOCAL = "file"  # Protocol of local folders


@dataclass(frozen=True)
class Place:
    """A folder given by its address; it is sent to workers as text and opens its storage there."""

    root: str  # path of the folder, or its address with a protocol
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


MAGIC = re.compile(r"[*?\[]")  # Characters that make a name a pattern

_PARTS = re.compile(r"\*\*/|\*\*|\*|\?|\[!?[^]/]+\]|.", re.DOTALL)


def is_pattern(name: str) -> bool:
    """Whether a name holds a wildcard."""
    return MAGIC.search(name) is not None


def folder_of(pattern: str) -> str:
    """The folder above the first wildcard; "" if there is none."""
    found = MAGIC.search(pattern)
    return pattern[: found.start() if found else None].rpartition("/")[0]


def matches(name: str, pattern: str) -> bool:
    """Whether a whole name matches a pattern: "*" and "?" stay within a folder, "**/" means any number of folders."""
    return _wildcards(pattern, "").fullmatch(name) is not None


def fits(name: str, pattern: str) -> bool:
    """Whether a name, or its end from some folder on, matches a pattern; arguments and errors as of `matches`."""
    return _wildcards(pattern, "(?:.*/)?").fullmatch(name) is not None


@lru_cache(maxsize=256)
def regular(pattern: str) -> Any:
    """A regular expression with the methods of `re.Pattern`, in the syntax of RE2."""
    # A native library, imported where it is needed.
    import re2

    options = re2.Options()
    options.log_errors = False
    try:
        return re2.compile(pattern, options)
    except UnicodeEncodeError:
        raise ParameterError(f"the pattern {pattern!r} is not Unicode text; save the file as UTF-8") from None
    except re2.error as error:
        reason = error.args[0].decode("utf-8", "replace")
        raise ParameterError(
            f"'{pattern}' is not a regular expression of RE2 ({reason}); write it without look-around (?=, ?!, ?<), "
            "back-references (\\1) and possessive repetition (*+), and repeat at most 1000 times"
        ) from None


@lru_cache(maxsize=256)
def _wildcards(pattern: str, before: str) -> Any:
    try:
        return regular("(?s)" + before + "".join(map(_translated, _PARTS.findall(pattern))))
    except ParameterError:
        raise ParameterError(f"the pattern '{pattern}' has a range that is none; write one such as [a-z]") from None


def _translated(part: str) -> str:
    fixed = {"**/": r"(?:[^/]+/)*", "**": r".*", "*": r"[^/]*", "?": r"[^/]"}
    if part in fixed:
        return fixed[part]
    if len(part) > 1:
        return part.replace("\\", "\\\\").replace("[!", "[^")
    return re.escape(part)


@dataclass(frozen=True)
class Found:
    """A recording before it is opened."""

    path: str  # path or address of the recording, as the system knows it
    bytes: int  # size [bytes]
    modified: str  # time of change, or the tag of the content in the storage (ETag)
    refusal: str = ""  # why it cannot be accessed; "" if it can

    @property
    def name(self) -> str:
        """Path or address as text, under which the recording is in the ledger."""
        return text_of(self.path)


def find(given: Iterable[str]) -> list[Found]:
    """All recordings once, sorted by name; inaccessible ones are included with the reason."""
    found: dict[str, Found] = {}
    for each in given:
        local = protocol_of(each) == LOCAL
        matched = {one.path: one for one in (_here(each.removeprefix("file://")) if local else _elsewhere(each))}
        if not matched:
            raise InputError(
                f"no recording matches {each}; give a file, a folder or a pattern in quotes, as 'drives/**/*.parquet'"
            )
        found |= matched
    return [found[name] for name in sorted(found)]


def _here(given: str) -> Iterator[Found]:
    # Absolute, since a later run or a worker of a cluster may start in another folder.
    text = os.path.abspath(expanded(given))
    path = Path(text)
    if path.is_dir():
        yield from (each for each in _below(text) if each.refusal or _is_recording(each.name))
    elif path.exists() or not is_pattern(text):
        if os.path.lexists(path):
            yield _looked_at(text)
    else:
        wanted = text_of(text)
        yield from (each for each in _below(folder_of(text) or "/") if each.refusal or matches(each.name, wanted))


def _below(folder: str) -> Iterator[Found]:
    refused: list[OSError] = []
    for above, folders, names in os.walk(folder, onerror=refused.append, followlinks=True):
        folders[:] = sorted(each for each in folders if not each.startswith("."))
        for name in names:
            if not name.startswith("."):
                yield _looked_at(os.path.normpath(os.path.join(above, name)))
    for error in refused:
        yield Found(str(error.filename), 0, "", f"the folder cannot be read ({reason_of(error).lower()})")


def _looked_at(path: str) -> Found:
    try:
        about = os.stat(path)
    except OSError as error:
        return Found(path, 0, "", f"it cannot be read ({reason_of(error).lower()})")
    return Found(path, about.st_size, str(about.st_mtime_ns))


def _elsewhere(given: str) -> Iterator[Found]:
    protocol = protocol_of(given)
    with answering(given):
        storage = storage_of(given)
        bare = str(storage._strip_protocol(given))
        # fsspec caches listings: files added since an earlier call in this process would be missed.
        storage.invalidate_cache()
        base = folder_of(bare) if is_pattern(bare) else bare
        listed: dict[str, Any] = storage.find(base, detail=True)
    wanted = text_of(bare) if is_pattern(bare) else ""
    for name, about in listed.items():
        if matches(text_of(name), wanted) if wanted else name == base or _is_recording(name):
            mark = about.get("ETag") or about.get("etag") or about.get("mtime") or about.get("LastModified") or ""
            yield Found(f"{protocol}://{name}", int(about.get("size") or 0), str(mark).strip('"'))


def _is_recording(name: str) -> bool:
    """Whether the ending is that of a format that tierod reads."""
    return Path(name).suffix.lower() in _endings()


@cache
def _endings() -> frozenset[str]:
    from tierod.io.readers import READERS

    return frozenset(ending for each in READERS.values() for ending in each.endings)
