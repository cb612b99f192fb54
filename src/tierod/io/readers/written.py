"""What the writers of tierod put beside the numbers, as JSON: taken as far as it is undamaged."""

from __future__ import annotations

import math
from typing import Any

from tierod.core.user_files import json_document

DAMAGED = "what tierod wrote beside the numbers (units, sources, metadata) is damaged and was left out"
"""Warning on a description that cannot be read."""

_TEXTS = ("name", "unit", "source", "note")


def description_in(text: str | bytes) -> dict[str, Any]:
    """The description of a recording (see `tierod.io.writers.layout`): origin, clocks, channels, metadata.

    Args:
        text: JSON

    Raises:
        ValueError: it is not whole
    """
    document = json_document(text)
    channels = _table(_table(document).get("channels", {}))
    for each in channels.values():
        if not all(isinstance(_table(each).get(key, ""), str) for key in _TEXTS):
            raise ValueError("a channel is described by something else than texts")
    for clock in _list(document.get("clocks", [])):
        names = [_table(clock).get("time"), *_list(clock.get("channels"))]
        if not all(isinstance(name, str) for name in names):
            raise ValueError("a clock is described by something else than names")
    origin = document.get("origin", 0.0)
    if isinstance(origin, bool) or not isinstance(origin, int | float) or not math.isfinite(origin):
        raise ValueError("the origin of the time is no number")
    return {**document, "channels": channels, "metadata": metadata_in(document.get("metadata", {}))}


def metadata_in(document: Any) -> dict[str, Any]:
    """Metadata of a recording; what a reader of results must know of it is a list of texts.

    Raises:
        ValueError: it is something else
    """
    warnings = _table(document).get("warnings", [])
    if not all(isinstance(each, str) for each in _list(warnings)):
        raise ValueError("the warnings are no texts")
    return document


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise ValueError("a list is something else")
    return value


def _table(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("a table is something else")
    return value
