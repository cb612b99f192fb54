"""The files that a scenario names, so that a recording can tell whether they are still the same."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tierod.core.errors import ParameterError
from tierod.core.toml import Document
from tierod.core.user_files import MOST_DATA_BYTES, read_bytes, read_text, toml


def named_files(document: Document) -> dict[str, str]:
    """SHA-256 of every file that a document names, and of those that these name; by the name as written."""
    found: dict[str, str] = {}
    _collect(document.content, document.path.parent, found)
    return found


def _collect(content: Any, folder: Path, found: dict[str, str]) -> None:
    for text in _texts(content):
        path = folder / text
        if text in found or path.suffix.lower() not in (".toml", ".csv") or not path.is_file():
            continue
        whole = read_bytes(path, "the file", ParameterError, most=MOST_DATA_BYTES)
        found[text] = hashlib.sha256(whole).hexdigest()
        if path.suffix.lower() == ".toml":
            _collect(toml(read_text(path, "the file", ParameterError), path, ParameterError), path.parent, found)


def _texts(content: Any) -> Iterator[str]:
    if isinstance(content, str):
        yield content
    elif isinstance(content, Mapping | list):
        for part in content.values() if isinstance(content, Mapping) else content:
            yield from _texts(part)
