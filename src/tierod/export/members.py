"""Names of C for dotted paths: members of structs, with arrays where a path ends in numbers."""

from __future__ import annotations

import re
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
        name: of C
        shape: of the array; () for a single number
        places: positions of its numbers in the flat order, row by row
    """

    name: str
    shape: tuple[int, ...]
    places: tuple[int, ...]

    @property
    def declarator(self) -> str:
        """Name and dimensions."""
        return self.name + "".join(f"[{size}]" for size in self.shape)

    @property
    def elements(self) -> tuple[str, ...]:
        """C of every number, in the order of `places`."""
        found = [self.name]
        for size in self.shape:
            found = [f"{each}[{k}]" for each in found for k in range(size)]
        return tuple(found)


def identifier(text: str) -> str:
    """A name of C for any text."""
    name = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "value"
    return f"{name}_" if name in KEYWORDS else f"n{name}" if name[0].isdigit() else name


def members(paths: Sequence[str]) -> tuple[Member, ...]:
    """Members of a struct for dotted paths; numbers at the end of a path are places in an array where none is lacking.

    Args:
        paths: in the flat order; each one once
    """
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
    """C of every number in the flat order."""
    named = {place: text for each in found for place, text in zip(each.places, each.elements, strict=True)}
    return tuple(named[place] for place in range(len(named)))


def _parted(path: str) -> tuple[str, tuple[int, ...]]:
    """Path without the numbers at its end, and these."""
    parts = path.split(".")
    count = len(parts)
    while count > 1 and parts[count - 1].isdigit():
        count -= 1
    return ".".join(parts[:count]), tuple(map(int, parts[count:]))


def _shape(indices: Sequence[tuple[int, ...]]) -> tuple[int, ...] | None:
    """Shape of the array that holds exactly these, in this order; None where there is none."""
    if len({len(each) for each in indices}) != 1:
        return None
    shape = tuple(1 + max(column) for column in zip(*indices, strict=True))
    whole = prod(shape) == len(indices) and list(indices) == sorted(set(indices))
    return shape if whole else None


def _distinct(found: Sequence[Member]) -> list[Member]:
    """The same, none named like another."""
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
