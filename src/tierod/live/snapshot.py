"""State of the sessions of a drive as plain values and arrays: the part of a checkpoint outside the blocks.

A session collects over a drive in ordinary objects: arrays, counters, lists, small classes. They are traversed from
their roots and written as a tree of plain values beside the arrays; `restoring` puts them back into sessions that were
opened anew. Objects that follow from the program or the user's files alone (functions, compiled blocks, vehicles,
monitors) are not written, and stay as they were opened. Reading executes nothing that a file could name, unlike
unpickling.
"""

from __future__ import annotations

import base64
import dataclasses
import functools
import hashlib
import types
from collections import Counter, deque
from collections.abc import Iterator, Mapping
from enum import Enum
from pathlib import PurePath
from typing import Any

import numpy as np

from tierod.core.block import tuning
from tierod.core.errors import TierodError
from tierod.core.graph import Scanner, Stream
from tierod.core.graph.lanes import SideBySide
from tierod.io.readers.mapping import Plan as Mapping_
from tierod.live.ticking import Ticker
from tierod.monitors.harness.session import Monitor, Variant
from tierod.vehicles import Vehicle

Node = None | bool | int | float | str | list["Node"]
"""A plain value, or a list whose first item is the letter of its kind."""

KEPT = (
    types.FunctionType, types.BuiltinFunctionType, types.MethodType, types.ModuleType, functools.partial, type,
    Scanner, SideBySide, Stream, Ticker, Mapping_, Monitor, Variant, Vehicle,
)  # fmt: skip
"""Types whose objects follow from the program and the user's files, and are not written."""

PLAIN = frozenset({list, dict, tuple, deque, set, frozenset, Counter})

MOST_DIGESTS = 1000
"""Number of cached digests of blocks above which the cache is cleared."""

ARRAYS = "biufcU"
"""Kinds of arrays that are written, as letters of NumPy: truth values, numbers and text."""


class NotStorable(TierodError):
    """An object that a checkpoint cannot hold."""


@dataclasses.dataclass
class Snapshot:
    """Values as a tree, and the arrays to which it refers by number."""

    tree: Node
    arrays: list[np.ndarray]


class Walk:
    """Converts values into a tree; an object that occurs twice is written once.

    Args:
        packages: top-level packages whose classes are written
    """

    def __init__(self, packages: frozenset[str]):
        self.arrays: list[np.ndarray] = []
        self._packages = packages
        self._numbers: dict[int, int] = {}
        self._met: list[object] = []

    def node(self, value: object) -> Node:
        """The value as a tree.

        Raises:
            NotStorable: the value contains an object that is neither written nor kept as opened
        """
        kind = type(value)
        if value is None or kind in (bool, int, str):
            return value  # type: ignore[return-value]  # narrowed by its type
        if kind is float:
            return value if np.isfinite(value) else ["f", repr(value)]  # type: ignore[call-overload, return-value]
        if kind is not np.ndarray and kind not in PLAIN and (special := self._special(kind, value)) is not None:
            return special
        if isinstance(value, tuple | frozenset):
            return self._fixed(value)
        if id(value) in self._numbers:
            return ["r", self._numbers[id(value)]]
        number = self._numbers[id(value)] = len(self._met)
        # The reference keeps the object alive: its id must not be given to another one during the walk.
        self._met.append(value)
        return self._numbered(value, number)

    def _special(self, kind: type, value: object) -> Node:
        """Node of a value that is neither a container nor an object with attributes; None for those."""
        if isinstance(value, Enum):
            return ["e", name_of(kind), value.name]
        if isinstance(value, KEPT):
            return ["k"]
        if is_frozen(kind) and hasattr(kind, "step") and hasattr(kind, "init"):
            return ["B", digest_of_block(value)]
        if isinstance(value, np.generic):
            return ["n", self._array(np.asarray(value))]
        if isinstance(value, bytes):
            return ["b", base64.b64encode(value).decode()]
        return ["p", str(value)] if isinstance(value, PurePath) else None

    def _fixed(self, value: tuple[object, ...] | frozenset[object]) -> Node:
        parts: list[Node] = [self.node(each) for each in value]
        if isinstance(value, frozenset):
            return ["s", parts]
        return ["t", parts] if type(value) is tuple else ["N", self._class(value), parts]

    def _numbered(self, value: object, number: int) -> Node:
        if isinstance(value, np.ndarray):
            return ["a", number, self._array(value)]
        if isinstance(value, list):
            return ["l", number, [self.node(each) for each in value]]
        if isinstance(value, deque):
            return ["q", number, value.maxlen, [self.node(each) for each in value]]
        if isinstance(value, set):
            return ["S", number, [self.node(each) for each in value]]
        if isinstance(value, Mapping):
            pairs: list[Node] = [[self.node(key), self.node(each)] for key, each in value.items()]
            return ["d", number, isinstance(value, Counter), pairs]
        attributes: list[Node] = [[name, self.node(each)] for name, each in held_by(value)]
        return ["o", number, self._class(value), attributes]

    def _class(self, value: object) -> str:
        if type(value).__module__.partition(".")[0] not in self._packages:
            raise NotStorable(f"a checkpoint cannot hold a {type(value).__qualname__} of {type(value).__module__}")
        return name_of(type(value))

    def _array(self, value: np.ndarray) -> int:
        if value.dtype.kind not in ARRAYS:
            raise NotStorable(f"a checkpoint cannot hold an array of {value.dtype}")
        # Copied, since the session continues while a thread writes the file.
        self.arrays.append(np.array(value, order="C"))
        return len(self.arrays) - 1


def digest_of(*parts: object) -> str:
    """Digest of values whose text (`repr`) is the same in every run."""
    return hashlib.sha256("\n".join(map(repr, parts)).encode()).hexdigest()[:32]


# Holds the block beside its digest, so that its id is not reused.
_DIGESTS: dict[int, tuple[object, str]] = {}


def digest_of_block(block: Any) -> str:
    """Digest of a block's type and tuning, since a state belongs to one calibration; cached, as blocks never change."""
    if id(block) not in _DIGESTS:
        if len(_DIGESTS) > MOST_DIGESTS:
            _DIGESTS.clear()
        name = f"{type(block).__module__}.{type(block).__qualname__}"
        _DIGESTS[id(block)] = block, digest_of(name, list(tuning(block)))
    return _DIGESTS[id(block)][1]


def name_of(kind: type) -> str:
    """Module and qualified name of a class, separated by a colon."""
    return f"{kind.__module__}:{kind.__qualname__}"


def held_by(value: object) -> Iterator[tuple[str, object]]:
    """Attributes of an object by name: the fields of a frozen dataclass, else all its slots and instance attributes.

    Raises:
        NotStorable: the object has no attributes that can be read, as a type written in C
    """
    if is_frozen(type(value)):
        yield from ((each.name, getattr(value, each.name)) for each in dataclasses.fields(value))  # type: ignore[arg-type]
        return
    slots = [name for kind in type(value).__mro__ for name in getattr(kind, "__slots__", ())]
    if not hasattr(value, "__dict__") and not slots:
        raise NotStorable(f"a checkpoint cannot hold a {type(value).__qualname__}")
    yield from ((name, getattr(value, name)) for name in slots if hasattr(value, name) and name != "__dict__")
    yield from list(getattr(value, "__dict__", {}).items())


def is_frozen(kind: type) -> bool:
    """Whether a class is a frozen dataclass, whose objects never change."""
    return dataclasses.is_dataclass(kind) and bool(kind.__dataclass_params__.frozen)  # type: ignore[attr-defined]


def snapshot(value: object, packages: frozenset[str] = frozenset({"tierod"})) -> Snapshot:
    """Snapshot of a value with all objects that it refers to.

    Args:
        value: any value
        packages: top-level packages whose classes may be written

    Raises:
        NotStorable: the value refers to an object that is neither written nor kept as opened
    """
    walk = Walk(packages)
    return Snapshot(walk.node(value), walk.arrays)
