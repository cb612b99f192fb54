"""The file of a fault memory: whole at every instant, checked when read, and never silently emptied."""

from __future__ import annotations

import contextlib
import glob
import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.diagnosis.entry import Entry
from tierod.diagnosis.trouble_codes import TroubleCodes
from tierod.errors import InputError, OutputError
from tierod.files import replacing
from tierod.user_files import MOST_DATA_BYTES, json_document, read_bytes

SCHEMA = "tierod.fault-memory/1"
"""Name and version of the file."""

_FIELDS = {"cycles": int, "date": str, "open": bool, "overflowed": bool, "entries": dict}


@dataclass(frozen=True)
class Kept:
    """A file that was read.

    Args:
        content: of the memory
        entries: by the name of their code, those of the table when it was written
        digest: of the content
        vehicle: whose memory it is
    """

    content: Mapping[str, Any]
    entries: Mapping[str, Entry]
    digest: str
    vehicle: str


def load(path: Path, codes: TroubleCodes, vehicle: str | None = None) -> Kept:
    """Read and check a file.

    Args:
        path: of the file
        codes: the table; it may have codes that it had not when the file was written
        vehicle: whose memory it must be; anyone's where None

    Raises:
        InputError: it cannot be read, is damaged, of another version, table or vehicle. What cannot be read as a memory
            is copied aside first; the message tells where
    """
    raw = _raw(path)
    try:
        kept = _checked(raw, codes)
    except ValueError as error:
        raise InputError(
            f"the fault memory {path} {error}; nothing was changed, and {_told_aside(path, raw)}. Name another file, "
            f"or begin anew with 'tierod faults clear {path}'"
        ) from None
    if vehicle is not None and kept.vehicle != vehicle:
        raise InputError(
            f"the fault memory {path} is of the vehicle '{kept.vehicle}', not '{vehicle}'; nothing was changed. Every "
            "vehicle has a memory of its own: name that of this vehicle, or a new file"
        )
    return kept


def _raw(path: Path) -> bytes:
    return read_bytes(path, "the fault memory", most=MOST_DATA_BYTES)


def _told_aside(path: Path, raw: bytes) -> str:
    """Half a sentence on the copy; a folder that takes none must not hide what is wrong with the file."""
    try:
        return f"a copy is kept as {_aside(path, raw)}"
    except OutputError:
        return "no copy could be kept beside it"


def _checked(raw: bytes, codes: TroubleCodes) -> Kept:
    """What a file holds; ValueError says in words what is wrong, as the end of a sentence."""
    try:
        document = json_document(raw)
    except ValueError:
        raise ValueError("is damaged: it is no whole JSON document") from None
    if not isinstance(document, dict) or "schema" not in document:
        raise ValueError("is not one: it has no schema")
    if document["schema"] != SCHEMA:
        raise ValueError(f"is of another version ({document['schema']}; this program reads {SCHEMA})")
    content = document.get("content")
    if not isinstance(content, dict) or document.get("digest") != digest_of(content, document.get("vehicle")):
        raise ValueError("is damaged: its content does not fit its digest")
    table = document.get("codes")
    if not isinstance(table, dict) or not table.items() <= codes.numbers.items():
        raise ValueError("was written with another table of trouble codes")
    if any(not isinstance(content.get(name), kind) for name, kind in _FIELDS.items()):
        raise ValueError("is damaged: a field is missing")
    if set(content["entries"]) != set(table):
        raise ValueError("is damaged: its codes are not those of its table")
    try:
        entries = {name: Entry.of(each) for name, each in content["entries"].items()}
    except (ValueError, TypeError, KeyError, AttributeError):
        raise ValueError("is damaged, or of another version: an entry is not whole") from None
    return Kept(content, entries, document["digest"], str(document["vehicle"]))


def save(path: Path, codes: TroubleCodes, vehicle: str, content: Mapping[str, Any], before: str) -> str:
    """Write a file, whole or not at all, and give the digest of what was written.

    Args:
        path: of the file
        codes: the table
        vehicle: whose memory it is
        content: of the memory
        before: digest of what was read or written last; "" for a new file

    Raises:
        OutputError: it cannot be written, or another program has written it meanwhile
    """
    # A link is followed once: lock, temporary file and new name belong into one folder.
    path = path.resolve()
    digest = digest_of(content, vehicle)
    document = {"schema": SCHEMA, "vehicle": vehicle, "codes": codes.numbers, "digest": digest, "content": content}
    with _alone(path.parent):
        if _digest_in(path) != before:
            raise OutputError(
                f"the fault memory {path} is not the one that was read: another program has written it meanwhile. "
                "It is untouched; run again"
            )
        with replacing(path) as temporary:
            temporary.write_text(json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n", "utf-8")
        _sweep(path)
        _settled(path.parent)
    return digest


def digest_of(content: Mapping[str, Any], vehicle: Any) -> str:
    """A digest of content and vehicle."""
    told = json.dumps([vehicle, content], sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(told.encode()).hexdigest()


def aside(path: Path) -> Path:
    """Copy a file beside itself under a name of its own and tell where.

    Raises:
        InputError: it cannot be read
        OutputError: the copy cannot be written
    """
    return _aside(path, _raw(path))


def remove(path: Path) -> Path:
    """Remove a file that cannot be read as a memory, and tell where its copy is; the next recording begins a new one.

    Raises:
        InputError: it cannot be read
        OutputError: it cannot be copied or removed
    """
    path = path.resolve()
    with _alone(path.parent):
        kept = aside(path)
        try:
            path.unlink()
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise OutputError(f"{path} cannot be removed ({reason}); check the permissions of its folder") from None
        _settled(path.parent)
    return kept


def _aside(path: Path, raw: bytes) -> Path:
    copy = path.with_name(f"{path.stem}.kept-{hashlib.sha256(raw).hexdigest()[:8]}{path.suffix}")
    if not copy.exists():
        with replacing(copy) as temporary:
            temporary.write_bytes(raw)
    return copy


def _digest_in(path: Path) -> str:
    try:
        return str(json_document(_raw(path))["digest"]) if path.exists() else ""
    except (InputError, OSError, ValueError, TypeError, LookupError):
        return "unreadable"


def _sweep(path: Path) -> None:
    """Remove what killed writers left beside the file; nobody else writes while the folder is locked."""
    for left in path.parent.glob(f".{glob.escape(path.stem[:100])}.{'[0-9a-f]' * 12}{glob.escape(path.suffix)}"):
        with contextlib.suppress(OSError):
            left.unlink()


@contextlib.contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """One writer at a time in a folder, where the system can lock folders."""
    try:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):
        yield
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _settled(folder: Path) -> None:
    """The new name on the disk too, so that a power cut cannot bring the old file back."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
