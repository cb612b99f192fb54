"""Unit, meaning and range of every leaf of a tree, read from the annotations and docstrings of its classes."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Hashable, Iterator
from functools import cache
from typing import Any, NamedTuple

from tierod.core.block import Ring
from tierod.core.fields import Meaning, below, hints
from tierod.core.signals import SIGNALS

_ENTRY = re.compile(r"^    (\w+(?:, \w+)*): (.*)$")


class Described(NamedTuple):
    """Description of a number.

    Args:
        unit: in the notation of pint; "" for none
        meaning: description in words; "" if unknown
        limits: range in words; "" for any value
    """

    path: str
    unit: str = ""
    meaning: str = ""
    limits: str = ""
    holder: str = ""


def described(tree: Any, path: str = "") -> Iterator[Described]:
    """Descriptions of every leaf of a tree of NamedTuples, dataclasses and tuples, in order."""
    yield from _below(tree, Described(path), Meaning(type(tree), None, None))


def of_signals(names: tuple[str, ...], tree: Any) -> tuple[Described, ...]:
    """Descriptions of a monitor's inputs: canonical signals from the catalogue, others from their annotations."""
    own = {each.path: each for each in described(tree)}
    return tuple(_signal(name) or own.get(name, Described(name)) for name in names)


def _signal(name: str) -> Described | None:
    found = SIGNALS.get(name)
    if found is None:
        return None
    low, high = found.plausible
    limits = "" if low == -high == -float("inf") else f"{low:g} to {high:g}"
    positive = f"; positive: {found.positive}" if found.positive else ""
    return Described(name, found.unit, found.meaning.rstrip(".") + positive, limits)


def _below(tree: Any, own: Described, means: Meaning) -> Iterator[Described]:
    if isinstance(tree, Ring):
        yield own
        return
    names = _fields(tree)
    if names is None:
        unit = own.unit if means.unit is None else means.unit
        yield own._replace(unit=unit, limits=str(means.limits) if means.limits else own.limits)
        return
    kind: Any = type(tree)
    texts, known = meanings(kind), hints(kind) if names and not names[0].isdigit() else {}
    for place, name in enumerate(names):
        part = tree[place] if names[0].isdigit() else getattr(tree, name)
        path = f"{own.path}.{name}" if own.path else name
        inner = below(known[name], means) if name in known else Meaning(type(part), means.unit, means.limits)
        text = texts.get(name, own.meaning if name.isdigit() else "")
        yield from _below(part, Described(path, own.unit, text, own.limits, kind.__name__), inner)


def _fields(tree: Any) -> list[str] | None:
    """Names of the parts of a tree; None for a leaf."""
    if isinstance(tree, tuple):
        return list(getattr(tree, "_fields", None) or map(str, range(len(tree))))
    if dataclasses.is_dataclass(tree) and not isinstance(tree, type):
        return [each.name for each in dataclasses.fields(tree)]
    return None


@cache
def meanings(kind: Hashable) -> dict[str, str]:
    """Descriptions of the fields of a class, read from "Args:" in its docstring."""
    _, found, rest = inspect.cleandoc(kind.__doc__ or "").partition("Args:\n")
    texts: dict[str, str] = {}
    names: list[str] = []
    for line in rest.splitlines() if found else ():
        if line and not line.startswith(" "):
            break
        if entry := _ENTRY.match(line):
            names = entry[1].split(", ")
            texts |= dict.fromkeys(names, entry[2])
        elif line.strip() and names:
            texts |= {name: f"{texts[name]} {line.strip()}" for name in names}
    return texts
