"""What formats share: their libraries, and the description that tierod stores beside the numbers."""

from __future__ import annotations

import importlib.util
import json
import logging
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import MissingExtra
from tierod.core.recording import Recording
from tierod.core.user_files import json_document


def require_library(library: str, extra: str, purpose: str) -> None:
    try:
        found = importlib.util.find_spec(library)
    except ValueError:
        found = None
    if found is None:
        raise MissingExtra(library, extra, purpose)


@contextmanager
def muted(library: str, level: int) -> Iterator[None]:
    """Suppress what a library logs below a level."""
    logger = logging.getLogger(library)
    before = logger.level
    logger.setLevel(level)
    try:
        yield
    finally:
        logger.setLevel(before)


@dataclass(frozen=True)
class Writer:
    title: str  # name of the format for users
    # function of a recording and the path of the file, which appears completely or not at all
    write: Callable[[Recording, str | Path], None]
    # function that raises MissingExtra where a library is not installed; None where none is needed
    require: Callable[[], None] | None = None


def plain(metadata: Mapping[str, object]) -> dict[str, Any]:
    """Metadata as JSON can hold it, without lone surrogates."""
    text = json.dumps(dict(metadata), default=str, ensure_ascii=False).encode("utf-8", "replace")
    content: dict[str, Any] = json.loads(text)
    return content


# Warning on a description that cannot be read
DAMAGED = "the units, sources and metadata that tierod wrote are damaged and were left out"

_TEXTS = ("name", "unit", "source", "note")


def description_in(text: str | bytes) -> dict[str, Any]:
    """The description of a recording (see `tierod.io.formats`): origin, clocks, channels, metadata."""
    document = json_document(text)
    channels = _table(_table(document).get("channels", {}))
    for each in channels.values():
        if not all(isinstance(_table(each).get(key, ""), str) for key in _TEXTS):
            raise ValueError("the description of a channel is not text")
    for clock in _list(document.get("clocks", [])):
        names = [_table(clock).get("time"), *_list(clock.get("channels"))]
        if not all(isinstance(name, str) for name in names):
            raise ValueError("the description of a clock holds no names")
    origin = document.get("origin", 0.0)
    if isinstance(origin, bool) or not isinstance(origin, int | float) or not math.isfinite(origin):
        raise ValueError("the origin of the time is not a number")
    return {**document, "channels": channels, "metadata": metadata_in(document.get("metadata", {}))}


def metadata_in(document: object) -> dict[str, Any]:
    """Metadata of a recording, in which the warnings must be a list of texts."""
    warnings = _table(document).get("warnings", [])
    if not all(isinstance(each, str) for each in _list(warnings)):
        raise ValueError("the warnings are not texts")
    return _table(document)


def _list(value: object) -> list[Any]:
    if not isinstance(value, list):
        raise ValueError("an entry that has to be a list is none")
    return value


def _table(value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("an entry that has to be a table is none")
    return value
