"""The matrix at a glance: one row per combination of levels, one column per fault and size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tierod.report.campaign.words import count

RIGHT = {"quiet", "found"}
"""Outcomes as they should be."""


@dataclass
class Square:
    """All seeds of one place."""

    right: int = 0
    wrong: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)

    @property
    def kind(self) -> str:
        """Class of the page."""
        return "bad" if self.wrong else "open" if self.lost else "good" if self.right else ""

    @property
    def symbol(self) -> str:
        """Tells the kind apart without colour."""
        return {"bad": "✕", "open": "?", "good": "✓", "": ""}[self.kind]

    @property
    def text(self) -> str:
        """How many were right, of how many."""
        total = self.right + len(self.wrong) + len(self.lost)
        return f"{self.right}/{total}" if total else ""

    @property
    def title(self) -> str:
        """What went wrong, in words."""
        told = [*self.wrong, *self.lost]
        return ", ".join(count(told.count(what), what, what) for what in dict.fromkeys(told))


@dataclass(frozen=True)
class Grid:
    """The matrix.

    Args:
        axes: that name the rows
        columns: sound, then faults with their sizes
        rows: (levels, squares)
    """

    axes: tuple[str, ...]
    columns: tuple[str, ...]
    rows: tuple[tuple[tuple[str, ...], tuple[Square, ...]], ...]


def grid(cells: Sequence[Mapping[str, Any]], monitor: str) -> Grid:
    """What one monitor made of every place."""
    apart = ("fault", "size", "seed")
    axes = tuple(axis for axis in cells[0]["place"] if axis not in apart) if cells else ()
    # Axes with one level would only repeat it.
    axes = tuple(axis for axis in axes if len({cell["place"][axis] for cell in cells}) > 1)
    rows: dict[tuple[str, ...], dict[str, Square]] = {}
    columns: dict[str, None] = {}
    for cell in cells:
        place = cell["place"]
        column = " ".join(filter(None, (place["fault"], place["size"])))
        columns[column] = None
        square = rows.setdefault(tuple(place[axis] for axis in axes), {}).setdefault(column, Square())
        _count(square, cell, next((each for each in cell["verdicts"] if each["monitor"] == monitor), None))
    table = tuple(
        (levels, tuple(squares.get(column, Square()) for column in columns)) for levels, squares in rows.items()
    )
    return Grid(axes, tuple(columns), table)


def _count(square: Square, cell: Mapping[str, Any], verdict: Mapping[str, Any] | None) -> None:
    if verdict is None or verdict["status"] is None:
        square.lost.append(cell["outcome"] if cell["outcome"] != "driven" else "not judged")
    elif verdict["outcome"] in RIGHT:
        square.right += 1
    elif verdict["outcome"] == "not judged":
        square.lost.append("not judged")
    else:
        square.wrong.append(verdict["outcome"])
