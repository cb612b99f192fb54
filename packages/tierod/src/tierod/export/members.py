"""C names for dotted paths: struct members, and arrays where the paths contain numbers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from math import prod
from typing import NamedTuple

_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while bool true false
"""
KEYWORDS = frozenset(_WORDS.split())


class Member(NamedTuple):
    """A member of a struct.

    Args:
        shape: of the array; () for a single number
        places: positions of its numbers in the flat order, row by row
    """

    name: str
    shape: tuple[int, ...]
    places: tuple[int, ...]

    @property
    def declarator(self) -> str:
        """C declarator: name and dimensions."""
        return self.name + "".join(f"[{size}]" for size in self.shape)

    @property
    def elements(self) -> tuple[str, ...]:
        """C code of every number, in the order of `places`."""
        found = [self.name]
        for size in self.shape:
            found = [f"{each}[{k}]" for each in found for k in range(size)]
        return tuple(found)


def identifier(text: str) -> str:
    """A valid C identifier for any text."""
    name = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "value"
    return f"{name}_" if name in KEYWORDS else f"n{name}" if name[0].isdigit() else name


def members(paths: Sequence[str]) -> tuple[Member, ...]:
    """Members of a struct for dotted paths; numbers in a path become array indices where the array is complete."""
    groups: dict[str, list[tuple[tuple[int, ...], int]]] = {}
    for place, path in enumerate(paths):
        stem, indices = _parted(path)
        groups.setdefault(stem, []).append((indices, place))
    found: list[Member] = []
    for stem, entries in groups.items():
        shape = _shape([indices for indices, _ in entries])
        if shape is not None:
            found.append(Member(identifier(stem), shape, tuple(place for _, place in entries)))
        else:
            found += [Member(identifier(paths[place]), (), (place,)) for _, place in entries]
    return tuple(_distinct(found))


def elements(found: Sequence[Member]) -> tuple[str, ...]:
    """C code of every number, in the flat order."""
    named = {place: text for each in found for place, text in zip(each.places, each.elements, strict=True)}
    return tuple(named[place] for place in range(len(named)))


def _parted(path: str) -> tuple[str, tuple[int, ...]]:
    """Path without its numbers, and these numbers; a path begins with a name."""
    first, *parts = path.split(".")
    return ".".join([first, *(part for part in parts if not part.isdigit())]), tuple(
        int(part) for part in parts if part.isdigit()
    )


def _shape(indices: Sequence[tuple[int, ...]]) -> tuple[int, ...] | None:
    """Shape of the array that holds exactly these indices in this order; None where there is no such array.

    Rows of unequal length are joined into a one-dimensional array.
    """
    if len({len(each) for each in indices}) != 1 or list(indices) != sorted(set(indices)):
        return None
    shape = tuple(1 + max(column) for column in zip(*indices, strict=True))
    if prod(shape) == len(indices):
        return shape
    rows = Counter(each[:-1] for each in indices)
    whole = all(max(each[-1] for each in indices if each[:-1] == row) + 1 == count for row, count in rows.items())
    return (len(indices),) if whole and len(rows) > 1 else None


def _distinct(found: Sequence[Member]) -> list[Member]:
    """Members with distinct names; repeated names get a number."""
    taken: set[str] = set()
    distinct = []
    for each in found:
        name, number = each.name, 1
        while name in taken:
            number += 1
            name = f"{each.name}_{number}"
        taken.add(name)
        distinct.append(each._replace(name=name))
    return distinct
