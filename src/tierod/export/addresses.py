"""Index expressions of loop bodies: C code in the loop counter i, with lookup tables where no formula fits."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

_NUMBER = re.compile(r"(?<=[\[ ])\d+(?=U?[\])])")
"""A whole number in square brackets, or at the end of a sum in parentheses."""


def columns_of(texts: Sequence[str]) -> tuple[list[str], list[tuple[int, ...]]] | None:
    """Common text of several pieces of C code and the whole numbers in between; None where the text itself differs.

    Args:
        texts: pieces of C code
    """
    common = _NUMBER.split(texts[0])
    if any(_NUMBER.split(text) != common for text in texts[1:]):
        return None
    rows = [tuple(map(int, _NUMBER.findall(text))) for text in texts]
    return common, list(zip(*rows, strict=True))


class Tables:
    """Lookup tables of one loop; equal tables are declared once.

    Args:
        declared: C code of a table's declaration from its type, name and values
    """

    def __init__(self, declared: Callable[[str, str, Sequence[str]], str]):
        self._declared = declared
        self._names: dict[tuple[str, tuple[str, ...]], str] = {}

    @property
    def text(self) -> str:
        """C code of all declarations."""
        return "".join(self._declared(kind, name, values) for (kind, values), name in self._names.items())

    def at(self, kind: str, values: Sequence[str]) -> str:
        """C code of the value in one iteration: a constant if all are equal, else a table look-up.

        Args:
            kind: C type of the values
            values: of all iterations, as C code
        """
        if len(set(values)) == 1:
            return values[0]
        name = self._names.setdefault((kind, tuple(values)), f"t{len(self._names)}")
        return f"{name}[i]"

    def number(self, values: Sequence[int], suffix: str = "") -> str:
        """C code of the whole number in one iteration, in brackets or at the end of a sum.

        Args:
            values: of all iterations
            suffix: of the literal if all values are equal
        """
        # An arithmetic progression becomes a formula in i; only irregular values need a table.
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
        """C code that reads or writes in one iteration.

        Args:
            texts: C code of every iteration; the texts differ in whole numbers only
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
