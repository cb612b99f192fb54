"""Search for recordings: folders, wildcard patterns and single files, local or in a remote storage."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError
from tierod.core.files import expanded, text_of
from tierod.fleet.patterns import folder_of, is_pattern, matches
from tierod.fleet.places import LOCAL, answering, protocol_of, reason_of, storage_of


@dataclass(frozen=True)
class Found:
    """A recording before it is opened.

    Args:
        path: path or address of the recording, as the system knows it
        bytes: size [bytes]
        modified: time of change, or the tag of the content in the storage (ETag)
        refusal: why it cannot be accessed; "" if it can
    """

    path: str
    bytes: int
    modified: str
    refusal: str = ""

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
