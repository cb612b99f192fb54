"""Conversion of TOML files to frozen dataclasses: units are converted, ranges checked, errors reported with line.

    document = Document.read("drive.toml")
    car = build(Car, document.content["car"], document, ("car",))

A class that reads its table itself has a class method `from_table(table, document, location, base)`.
Numbers are SI, or texts with a unit: `speed = 16.7` is `speed = "60 km/h"`. A field that may hold one of several
dataclasses is chosen by the key `kind`: the name of the class in lower case with hyphens.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Set
from pathlib import Path
from typing import Any

from tierod.core.errors import nearest
from tierod.core.fields import Meaning, numbers
from tierod.core.toml_builder import Builder
from tierod.core.toml_document import Document, Location

__all__ = ["Document", "Location", "build", "override", "quoted"]


def build(
    kind: object,
    table: object,
    document: Document,
    location: Location = (),
    *,
    base: object = None,
    signal: str | None = None,
) -> Any:
    """A frozen dataclass from a table.

    Args:
        kind: the dataclass, or a union of dataclasses of which the key `kind` chooses one
        table: as parsed from TOML
        document: document that holds the table
        location: location of the table in the document
        base: instance that provides the fields which the table leaves out, in place of the defaults of the class
        signal: unit that replaces `SIGNAL_UNIT` in annotations; None where there is no signal

    Raises:
        ParameterError: an unknown or missing key, a wrong type, unit or value, with file, line and nearest name
    """
    return Builder(document, signal).value(Meaning(kind, None, None), table, tuple(location), base)


def override(
    instance: object,
    changes: Mapping[str, object],
    document: Document | None = None,
    location: Location = (),
    what: str = "",
) -> Any:
    """A nested frozen dataclass with some of its fields replaced.

    Args:
        instance: for example a car
        changes: value by dotted path, `{"steering.friction.level": "8 N*m"}`, or nested tables
        document: document that holds the changes, if they come from a file
        location: location of their table in the document
        what: name of the instance in a message; that of its class where it is empty

    Raises:
        ParameterError: a wrong path, with the nearest right ones; a wrong value as for `build`
    """
    source = document or Document({}, "", Path(what or type(instance).__name__))
    known = numbers(instance)
    places = {".".join(path.split(".")[:depth]) for path in known for depth in range(1, path.count(".") + 1)}
    nested: dict[str, Any] = {}
    for path, value in flat(changes, {"kind"}):
        if path not in known and path not in places and not _has(instance, path):
            raise source.error((*location, path), f"no parameter is called '{path}'{nearest(path, known)}")
        below = nested
        *above, last = path.split(".")
        for name in above:
            below = below.setdefault(name, {})
        below[last] = value
    return Builder(source, None).value(Meaning(type(instance), None, None), nested, tuple(location), instance)


def quoted(text: str) -> str:
    """A text as TOML writes it."""
    # The control character DEL needs no escape in JSON, but in TOML it does.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def flat(table: Mapping[str, Any], keys: Set[str], above: str = "") -> list[tuple[str, Any]]:
    """(dotted path, value) of nested tables."""
    pairs: list[tuple[str, Any]] = []
    for name, value in table.items():
        if isinstance(value, Mapping) and not keys & set(value):
            pairs.extend(flat(value, keys, f"{above}{name}."))
        else:
            pairs.append((f"{above}{name}", value))
    return pairs


def _has(instance: object, path: str) -> bool:
    """Whether a dotted path leads to a field that is not a float."""
    for name in path.split("."):
        if not (dataclasses.is_dataclass(instance) and name in {field.name for field in dataclasses.fields(instance)}):
            return False
        instance = getattr(instance, name)
    return True
