"""The file of a fault memory: whole at every instant, checked when read, and never silently emptied."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, OutputError
from tierod.core.files import holding, replacing, sweep
from tierod.core.user_files import MOST_DATA_BYTES, json_document, read_bytes
from tierod.diagnosis.entry import Entry
from tierod.diagnosis.trouble_codes import TroubleCodes

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
            is copied aside first; the message names the place
    """
    raw = _raw(path)
    try:
        kept = _checked(raw, codes)
    except ValueError as error:
        raise InputError(
            f"the fault memory {path} {error}; nothing was changed, and {_kept_aside(path, raw)}. Name another file, "
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


def _kept_aside(path: Path, raw: bytes) -> str:
    """Half a sentence on the copy; a folder that takes none must not hide what is wrong with the file."""
    try:
        return f"a copy is kept as {_aside(path, raw)}"
    except OutputError:
        return "no copy could be kept beside it"


def _checked(raw: bytes, codes: TroubleCodes) -> Kept:
    """Content of a checked file; ValueError names the defect in words, as the end of a sentence."""
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
    if not _are_recordings(content.get("recordings", {})):  # older files have none
        raise ValueError("is damaged: its recordings are not whole")
    if set(content["entries"]) != set(table):
        raise ValueError("is damaged: its codes are not those of its table")
    try:
        entries = {name: Entry.of(each) for name, each in content["entries"].items()}
    except (ValueError, TypeError, KeyError, AttributeError):
        raise ValueError("is damaged, or of another version: an entry is not whole") from None
    return Kept(content, entries, document["digest"], str(document["vehicle"]))


def _are_recordings(found: object) -> bool:
    """Whether this is fingerprint -> (number of the cycle, its date)."""
    return isinstance(found, dict) and all(
        isinstance(each, list) and [type(part) for part in each] == [int, str] for each in found.values()
    )


def save(path: Path, codes: TroubleCodes, vehicle: str, content: Mapping[str, object], before: str) -> str:
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
    with holding(path) as target:
        return save_held(target, codes, vehicle, content, before)


def save_held(path: Path, codes: TroubleCodes, vehicle: str, content: Mapping[str, object], before: str) -> str:
    """Save into a file that is locked already; otherwise as `save`.

    Args:
        path: of the file, as `holding` gives it
        codes, vehicle, content, before: as of `save`

    Raises:
        OutputError: it cannot be written, or a program that does not hold it has written it meanwhile
    """
    digest = digest_of(content, vehicle)
    document = {"schema": SCHEMA, "vehicle": vehicle, "codes": codes.numbers, "digest": digest, "content": content}
    if _digest_in(path) != before:
        raise OutputError(
            f"the fault memory {path} is not the one that was read: another program has written it meanwhile. Its "
            "content stays, without what was added here since; open it again and repeat the cycle"
        )
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n", "utf-8")
    sweep(path, age=0.0)  # no other process writes while the folder is held
    _settled(path.parent)
    return digest


def digest_of(content: Mapping[str, object], vehicle: object) -> str:
    """A digest of content and vehicle."""
    text = json.dumps([vehicle, content], sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def aside(path: Path) -> Path:
    """Copy a file beside itself under a name of its own and return it.

    Raises:
        InputError: it cannot be read
        OutputError: the copy cannot be written
    """
    return _aside(path, _raw(path))


def remove(path: Path) -> Path:
    """Remove a held file that cannot be read as a memory after a copy of it, whose path is returned.

    Raises:
        InputError: it cannot be read
        OutputError: it cannot be copied or removed
    """
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


def _settled(folder: Path) -> None:
    """The new name on the disk too, so that a power cut cannot bring the old file back."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
