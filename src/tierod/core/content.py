"""Contents of a study beside its claims: headings, tables and charts, as plain data that the report draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tierod.core.claims import Claim

Numbers = Sequence[float] | np.ndarray


@dataclass(frozen=True)
class Heading:
    """Begins a part of the study.

    Args:
        title: a few words
        text: paragraphs, one per entry
    """

    title: str
    text: tuple[str, ...] = ()


@dataclass(frozen=True)
class Table:
    """Some figures with a sentence on their meaning.

    Args:
        title: a sentence without full stop, with the unit
        header: names of the columns
        rows: cells as text; the first one names the row
        note: hint for reading it
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    @property
    def numeric(self) -> tuple[int, ...]:
        """The columns that hold numbers."""
        columns = range(len(self.header))
        return tuple(i for i in columns if all(_is_figure(row[i]) for row in self.rows))

    def markdown(self) -> str:
        """The table as it stands in the documentation: columns of numbers to the right."""
        rule = tuple("---:" if i in self.numeric else "---" for i in range(len(self.header)))
        lines = ["| " + " | ".join(line) + " |" for line in (self.header, rule, *self.rows)]
        return f"**{self.title}**\n\n" + "\n".join(lines) + "\n" + (f"\n{self.note}\n" if self.note else "")


def _is_figure(cell: str) -> bool:
    return not cell or cell[:1] in "+-.0123456789–−±∞"


@dataclass(frozen=True)
class Lines:
    """A curve; NaN breaks it."""

    name: str
    x: Numbers
    y: Numbers
    dashed: bool = False


@dataclass(frozen=True)
class Bars:
    """A histogram: shares between edges."""

    name: str
    edges: Numbers
    shares: Numbers


@dataclass(frozen=True)
class Points:
    """Marks at numbers or at named places, with the range that each stands for."""

    name: str
    x: Numbers | Sequence[str]
    y: Numbers
    low: Numbers | None = None
    high: Numbers | None = None


@dataclass(frozen=True)
class Band:
    """The range between two curves; NaN leaves a gap. One of the name of a curve has its colour."""

    name: str
    x: Numbers
    low: Numbers
    high: Numbers


@dataclass(frozen=True)
class Boxes:
    """Boxes at named places: mean, one standard deviation as the box, two as whiskers."""

    name: str
    places: Sequence[str]
    mean: Numbers
    deviation: Numbers


@dataclass(frozen=True, eq=False)
class Cells:
    """A table of shares as colours, alone in its panel: which row goes with which column.

    Args:
        name: of the quantity that is shared out
        down, across: names of rows and columns
        shares: 0 to 1, (rows, columns); NaN leaves a cell empty
    """

    name: str
    down: Sequence[str]
    across: Sequence[str]
    shares: np.ndarray


Mark = Lines | Bars | Points | Band | Boxes | Cells


@dataclass(frozen=True)
class Panel:
    """One field of a chart with axes of its own.

    Args:
        title: above it
        x_title, y_title: of the axes, with unit
        marks: the drawn series; a name that two panels share has the same colour in both
        levels: dashed lines across at named heights
        uprights: dashed lines up at named places
        logarithmic: whether the vertical axis is
        logarithmic_along: whether the horizontal axis is
        sideways: whether the named places of points stand below each other, and their heights run to the right; for
            many places with long names. The titles of the axes and the levels stay with their values
        rows: names of heights, in place of numbers up the vertical axis
        to_scale: whether a metre up is as long as a metre along
    """

    title: str
    x_title: str
    y_title: str
    marks: tuple[Mark, ...]
    levels: tuple[tuple[str, float], ...] = ()
    uprights: tuple[tuple[str, float], ...] = ()
    logarithmic: bool = False
    logarithmic_along: bool = False
    sideways: bool = False
    rows: tuple[tuple[str, float], ...] = ()
    to_scale: bool = False


@dataclass(frozen=True)
class Chart:
    """One figure of a study, its panels above each other.

    Args:
        name: identifies it in the page: words joined by hyphens
        title: a few words
        caption: hint for reading it
        alternative: its content as text, for those who do not see it
        panels: from top to bottom
    """

    name: str
    title: str
    caption: str
    alternative: str
    panels: tuple[Panel, ...]


Item = Heading | Table | Chart | Claim
"""What a study gives, one after the other."""
