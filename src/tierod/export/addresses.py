"""What the turns of a loop take, by one text of C with the number of the turn, and with tables where it needs any."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

_NUMBER = re.compile(r"(?<=[\[ ])\d+(?=U?[\])])")
"""A whole number in brackets, or at the end of a sum in brackets."""


def columns_of(texts: Sequence[str]) -> tuple[list[str], list[tuple[int, ...]]] | None:
    """What some texts have in common, and the whole numbers between; None where they differ in more than these.

    Args:
        texts: of C
    """
    common = _NUMBER.split(texts[0])
    if any(_NUMBER.split(text) != common for text in texts[1:]):
        return None
    rows = [tuple(map(int, _NUMBER.findall(text))) for text in texts]
    return common, list(zip(*rows, strict=True))


class Tables:
    """Tables of one loop; equal ones stand once.

    Args:
        declared: C of the declaration of a table, given its type, its name and its values
    """

    def __init__(self, declared: Callable[[str, str, Sequence[str]], str]):
        self._declared = declared
        self._names: dict[tuple[str, tuple[str, ...]], str] = {}

    @property
    def text(self) -> str:
        """C of all declarations."""
        return "".join(self._declared(kind, name, values) for (kind, values), name in self._names.items())

    def at(self, kind: str, values: Sequence[str]) -> str:
        """C of the value of a turn.

        Args:
            kind: type of C
            values: of all turns, as C writes them
        """
        if len(set(values)) == 1:
            return values[0]
        name = self._names.setdefault((kind, tuple(values)), f"t{len(self._names)}")
        return f"{name}[i]"

    def number(self, values: Sequence[int], suffix: str = "") -> str:
        """C of the whole number of a turn, in brackets or at the end of a sum.

        Args:
            values: of all turns
            suffix: of a literal that stands there
        """
        first, step = values[0], values[1] - values[0]
        if any(value != first + step * turn for turn, value in enumerate(values)):
            return self.at("uint16_t", [f"{value}U" for value in values])
        if step == 0:
            return f"{first}{suffix}"
        if step < 0:
            return f"{first}U - {'i' if step == -1 else f'({-step}U * i)'}"
        turned = "i" if step == 1 else f"({step}U * i)"
        return turned if first == 0 else f"{first}U + {turned}"

    def indexed(self, texts: Sequence[str]) -> str:
        """C of what a turn reads or writes.

        Args:
            texts: of all turns; they differ in whole numbers alone
        """
        found = columns_of(texts)
        if found is None:
            raise AssertionError(f"{texts[0]} and {texts[-1]} differ in more than whole numbers")
        common, columns = found
        text = common[0]
        for column, rest in zip(columns, common[1:], strict=True):
            literal = rest.startswith("U")
            text += self.number(column, "U" if literal else "") + (rest[1:] if literal else rest)
        return text
