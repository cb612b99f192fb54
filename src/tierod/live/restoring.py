"""Restores the content of a snapshot into sessions that were opened anew."""

from __future__ import annotations

import base64
import dataclasses
import sys
from collections import Counter, deque
from collections.abc import Callable, MutableMapping, MutableSequence
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from tierod.live.snapshot import Node, Snapshot, digest_of_block, held_by, is_frozen, name_of

Opening = Callable[[Any, "Held"], None]
"""Function that opens the members of an object before it is filled from the snapshot."""


class Unfit(Exception):
    """Snapshot that does not fit the opened objects; the message names the place."""


_MISSING = object()


class Held:
    """Attributes of one object in a snapshot."""

    def __init__(self, reader: Restoring, nodes: dict[str, Node]):
        self._reader, self._nodes = reader, nodes

    def node(self, name: str) -> Any:
        """The node of an attribute as written; None where there is none."""
        return self._nodes.get(name)

    def value(self, name: str) -> Any:
        """The value of an attribute that contains no opened object."""
        return self._reader.value(self._nodes.get(name))


class Restoring:
    """Reads a snapshot into objects that were opened anew.

    Args:
        found: the snapshot
        packages: top-level packages whose classes may be instantiated
        openings: by class, a function called before its objects are filled
    """

    def __init__(self, found: Snapshot, packages: frozenset[str], openings: dict[type, Opening]):
        self._arrays, self._packages, self._openings = found.arrays, packages, openings
        self._made: dict[int, object] = {}

    def value(self, node: Node, opened: object = _MISSING) -> Any:
        """Value of a node.

        Args:
            node: node of the snapshot
            opened: object at its place now

        Raises:
            Unfit: the node is malformed, or does not fit the opened object
        """
        if not isinstance(node, list):
            return node
        kind, *rest = node
        make = getattr(self, f"_of_{kind}", None) if isinstance(kind, str) and len(kind) == 1 else None
        if make is None:
            raise Unfit(f"{kind!r} is not a kind of value")
        return make(opened, *rest)

    def _of_f(self, opened: object, text: str) -> float:
        return float(text)

    def _of_e(self, opened: object, name: str, member: str) -> Enum:
        kind = self._class(name)
        if not issubclass(kind, Enum):
            raise Unfit(f"{name} is no enumeration")
        return kind[member]

    def _of_k(self, opened: object) -> object:
        if opened is _MISSING:
            raise Unfit("a value that is not in the checkpoint is not in the program either")
        return opened

    def _of_B(self, opened: object, digest: str) -> object:  # letter of compiled blocks
        if opened is _MISSING or opened is None or digest_of_block(opened) != digest:
            raise Unfit("it belongs to another calibration")
        return opened

    def _of_n(self, opened: object, number: int) -> object:
        return self._arrays[number][()]

    def _of_b(self, opened: object, text: str) -> bytes:
        return base64.b64decode(text, validate=True)

    def _of_p(self, opened: object, text: str) -> Path:
        return Path(text)

    def _of_r(self, opened: object, number: int) -> object:
        return self._made[number]

    def _of_s(self, opened: object, parts: list[Node]) -> frozenset[object]:
        return frozenset(self.value(each) for each in parts)

    def _of_S(self, opened: object, number: int, parts: list[Node]) -> set[object]:  # letter of mutable sets
        made = self._made[number] = {self.value(each) for each in parts}
        return made

    def _of_t(self, opened: object, parts: list[Node]) -> object:
        return _same_or(opened, tuple(self._parts(opened, parts)))

    def _of_N(self, opened: object, name: str, parts: list[Node]) -> object:  # letter of named tuples
        kind = self._class(name)
        if not issubclass(kind, tuple):
            raise Unfit(f"{name} is no tuple")
        return _same_or(opened, tuple.__new__(kind, self._parts(opened, parts)))

    def _parts(self, opened: object, parts: list[Node]) -> list[object]:
        there = opened if isinstance(opened, tuple) and len(opened) == len(parts) else [_MISSING] * len(parts)
        return [self.value(each, own) for each, own in zip(parts, there, strict=True)]

    def _of_a(self, opened: object, number: int, place: int) -> np.ndarray:
        made = self._made[number] = self._arrays[place].copy()
        return made

    def _of_l(self, opened: object, number: int, parts: list[Node]) -> object:
        return self._listed(opened if type(opened) is list else [], number, parts)

    def _of_q(self, opened: object, number: int, longest: int | None, parts: list[Node]) -> object:
        own = opened if isinstance(opened, deque) and opened.maxlen == longest else deque[object](maxlen=longest)
        return self._listed(own, number, parts)

    def _listed(self, made: Any, number: int, parts: list[Node]) -> Any:
        """Fill a list in place, since other objects may refer to it."""
        assert isinstance(made, MutableSequence)
        before = [*made, *([_MISSING] * len(parts))]
        self._made[number] = made
        made.clear()
        made.extend(self.value(each, own) for each, own in zip(parts, before, strict=False))
        return made

    def _of_d(self, opened: object, number: int, counts: bool, pairs: list[Any]) -> MutableMapping[Any, Any]:
        fits = isinstance(opened, Counter) if counts else isinstance(opened, dict)
        made: Any = opened if fits else Counter() if counts else {}
        self._made[number] = made
        before = dict(made)
        made.clear()
        for key, each in pairs:
            name = self.value(key)
            made[name] = self.value(each, before.get(name, _MISSING))
        return made  # type: ignore[no-any-return]  # a dict or a counter

    def _of_o(self, opened: object, number: int, name: str, attributes: list[Any]) -> object:
        kind = type(opened) if name_of(type(opened)) == name else self._class(name)
        if is_frozen(kind):
            return self._frozen(kind, opened, number, attributes)
        made: Any = opened if type(opened) is kind else object.__new__(kind)
        self._made[number] = made
        for each, opening in self._openings.items():
            if isinstance(made, each):
                opening(made, Held(self, dict(attributes)))
        for key, each in attributes:
            setattr(made, key, self.value(each, getattr(made, key, _MISSING)))
        return made

    def _frozen(self, kind: type, opened: object, number: int, attributes: list[Any]) -> object:
        """The opened object if its content is equal, else a new one; a compiled block belongs to the very object."""
        before = dict(held_by(opened)) if type(opened) is kind else {}
        held = {key: self.value(each, before.get(key, _MISSING)) for key, each in attributes}
        if held.keys() == before.keys() and all(_same(held[key], before[key]) for key in held):
            self._made[number] = opened
            return opened
        if held.keys() != {each.name for each in dataclasses.fields(kind)}:
            raise Unfit(f"{kind.__qualname__} has other fields")
        made: Any = object.__new__(kind)
        self._made[number] = made
        for key, each in held.items():
            object.__setattr__(made, key, each)
        return made

    def _class(self, name: str) -> type:
        """Class by its name, from a loaded module of the allowed packages; a file can make no other."""
        module, _, path = name.partition(":")
        found: Any = sys.modules.get(module) if module.partition(".")[0] in self._packages else None
        for part in path.split("."):
            found = getattr(found, part, None)
        # A finalizer would run code with values from the file.
        if not isinstance(found, type) or found.__module__ != module or hasattr(found, "__del__"):
            raise Unfit(f"there is no class {name}")
        return found


def _same(first: object, second: object) -> bool:
    plain = type(first) is type(second) and isinstance(first, bool | int | float | str | None)
    return first is second or (plain and first == second)


def _same_or(opened: object, made: Any) -> Any:
    """The opened tuple if its items are the same, else the new one."""
    alike = type(opened) is type(made) and len(opened) == len(made)  # type: ignore[arg-type]  # tuples both
    return opened if alike and all(map(_same, made, opened)) else made  # type: ignore[call-overload]  # a tuple


def restored(found: Snapshot, opened: object, packages: frozenset[str], openings: dict[type, Opening]) -> Any:
    """Value that a snapshot holds, restored into the opened objects as far as their classes are the same.

    Args:
        found: the snapshot
        opened: objects that were opened anew
        packages: top-level packages whose classes may be instantiated
        openings: by class, a function called before its objects are filled

    Raises:
        Unfit: the snapshot does not fit the opened objects
    """
    try:
        return Restoring(found, packages, openings).value(found.tree, opened)
    except (TypeError, ValueError, KeyError, IndexError, AttributeError, RecursionError) as error:
        raise Unfit(f"{type(error).__name__}: {error}") from None
