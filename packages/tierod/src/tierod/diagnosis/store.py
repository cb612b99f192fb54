"""File of a fault memory: written atomically, checked when read, and never emptied without a copy."""

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
from tierod.core.user_files import MOST_DATA_BYTES, json_document, names_schema, read_bytes
from tierod.diagnosis.entry import Entry
from tierod.diagnosis.trouble_codes import TroubleCodes

SCHEMA = "tierod.fault-memory/1"  # Name and version of the file format
_FIELDS = {"cycles": int, "date": str, "open": bool, "overflowed": bool, "entries": dict}


@dataclass(frozen=True)
class Kept:
    """Content of a file."""

    content: Mapping[str, Any]
    entries: Mapping[str, Entry]  # by name of their code; the codes are those of the table at the time of writing
    digest: str
    vehicle: str


def load(path: Path, codes: TroubleCodes, vehicle: str | None = None) -> Kept:
    """Read and check a file.

    Args: codes: table of trouble codes; it may contain codes added since the file was written; vehicle: required
    vehicle name; None for any.
    """
    raw = _memory(path)
    try:
        kept = _checked(raw, codes)
    except ValueError as error:
        raise InputError(
            f"the fault memory {path} {error}; nothing was changed. Name another file, or start again with 'tierod "
            f"faults clear {path}', which keeps a copy"
        ) from None
    if vehicle is not None and kept.vehicle != vehicle:
        raise InputError(
            f"the fault memory {path} belongs to the vehicle '{kept.vehicle}', not '{vehicle}'; nothing was changed. "
            "Every vehicle has its own memory: name that of this vehicle, or a new file"
        )
    return kept


def _raw(path: Path) -> bytes:
    return read_bytes(path, "the fault memory", most=MOST_DATA_BYTES)


def _memory(path: Path) -> bytes:
    """Content of a file that is a fault memory, perhaps a damaged one: any other is not to be touched."""
    raw = _raw(path)
    if not names_schema(raw, SCHEMA):
        raise InputError(f"{path} is no fault memory; nothing was changed. Name the file of a memory, or a new file")
    return raw


def _checked(raw: bytes, codes: TroubleCodes) -> Kept:
    """Content of a checked file; the ValueError states the defect as the end of a sentence."""
    try:
        document = json_document(raw)
    except ValueError:
        raise ValueError("is damaged: it is not a complete JSON document") from None
    if (schema := document.get("schema")) != SCHEMA:
        raise ValueError(f"is of another version ({schema}; this program reads {SCHEMA})")
    content = document.get("content")
    if not isinstance(content, dict) or document.get("digest") != digest_of(content, document.get("vehicle")):
        raise ValueError("is damaged: its content does not match its digest")
    table = document.get("codes")
    if not isinstance(table, dict) or not table.items() <= codes.numbers.items():
        raise ValueError("was written with another table of trouble codes")
    if any(not isinstance(content.get(name), kind) for name, kind in _FIELDS.items()):
        raise ValueError("is damaged: a field is missing")
    if not _are_recordings(content.get("recordings", {})):  # older files have none
        raise ValueError("is damaged: its recordings are incomplete")
    if set(content["entries"]) != set(table):
        raise ValueError("is damaged: its codes do not match its table")
    try:
        entries = {name: Entry.of(each) for name, each in content["entries"].items()}
    except (ValueError, TypeError, KeyError, AttributeError):
        raise ValueError("is damaged, or of another version: an entry is incomplete") from None
    return Kept(content, entries, document["digest"], str(document["vehicle"]))


def _are_recordings(found: object) -> bool:
    """Whether a value maps fingerprints to (number of the cycle, its date)."""
    return isinstance(found, dict) and all(
        isinstance(each, list) and [type(part) for part in each] == [int, str] for each in found.values()
    )


def save(path: Path, codes: TroubleCodes, vehicle: str, content: Mapping[str, object], before: str) -> str:
    """Write a file atomically, and return the digest of its content."""
    with holding(path) as target:
        return save_held(target, codes, vehicle, content, before)


def save_held(path: Path, codes: TroubleCodes, vehicle: str, content: Mapping[str, object], before: str) -> str:
    """Write a file that is locked already; otherwise like `save`."""
    digest = digest_of(content, vehicle)
    document = {"schema": SCHEMA, "vehicle": vehicle, "codes": codes.numbers, "digest": digest, "content": content}
    if _digest_in(path) != before:
        raise OutputError(
            f"the fault memory {path} is not the one that was read: another program has changed it in the meantime. "
            "Its content is kept, without the changes made here; open it again and repeat the cycle"
        )
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n", "utf-8")
    sweep(path, age=0.0)  # no other process writes while the folder is held
    _settled(path.parent)
    return digest


def digest_of(content: Mapping[str, object], vehicle: object) -> str:
    text = json.dumps([vehicle, content], sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def aside(path: Path) -> Path:
    """Copy a memory to its folder under a name of its own, and return the path of the copy."""
    raw = _memory(path)
    # Named by its content, so that repeated attempts leave one copy.
    copy = path.with_name(f"{path.stem}.kept-{hashlib.sha256(raw).hexdigest()[:8]}{path.suffix}")
    if not copy.exists():
        with replacing(copy) as temporary:
            temporary.write_bytes(raw)
    return copy


def remove(path: Path) -> Path:
    """Remove a locked, damaged memory after copying it, and return the path of the copy."""
    kept = aside(path)
    try:
        path.unlink()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise OutputError(f"{path} cannot be removed ({reason}); check the permissions of its folder") from None
    _settled(path.parent)
    return kept


def _digest_in(path: Path) -> str:
    try:
        return str(json_document(_raw(path))["digest"]) if path.exists() else ""
    except (InputError, OSError, ValueError, TypeError, LookupError):
        # Differs from any digest, so that a damaged file is not overwritten.
        return "unreadable"


def _settled(folder: Path) -> None:
    """Flush the folder to disk, so that a power loss cannot bring the old file back."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
