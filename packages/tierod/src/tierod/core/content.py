"""Content of a study beside its claims: headings, tables and charts, as plain data for the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tierod.core.claims import Claim

Numbers = Sequence[float] | np.ndarray


@dataclass(frozen=True)
class Heading:
    """Heading of a part of a study, with its introduction."""

    title: str
    text: tuple[str, ...] = ()


@dataclass(frozen=True)
class Table:
    """Table of figures.

    Args:
        title: meaning of the figures, a sentence without full stop, with the unit
        rows: cells as text; the first one names the row
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    @property
    def numeric(self) -> tuple[int, ...]:
        """Indices of the columns that hold numbers."""
        columns = range(len(self.header))
        return tuple(i for i in columns if all(_is_figure(row[i]) for row in self.rows))

    def markdown(self) -> str:
        """The table in Markdown, columns of numbers aligned to the right."""
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
    """Points at numbers or at named places, each with an optional range."""

    name: str
    x: Numbers | Sequence[str]
    y: Numbers
    low: Numbers | None = None
    high: Numbers | None = None


@dataclass(frozen=True)
class Band:
    """The range between two curves; NaN leaves a gap. A band with the name of a curve has its colour."""

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
    """Table of shares as colours (such as a confusion matrix), alone in its panel.

    Args:
        shares: 0 to 1, (rows, columns); NaN leaves a cell empty
    """

    name: str
    down: Sequence[str]
    across: Sequence[str]
    shares: np.ndarray


Mark = Lines | Bars | Points | Band | Boxes | Cells


@dataclass(frozen=True)
class Panel:
    """One panel of a chart with axes of its own.

    Args:
        marks: the drawn series; a name that two panels share has the same colour in both
        levels: horizontal dashed lines at named values
        logarithmic: whether the vertical axis is logarithmic
        logarithmic_along: whether the horizontal axis is logarithmic
        sideways: whether the named places of points are listed from top to bottom and their values run to the right,
            for many places with long names. The titles of the axes and the levels stay with their values
        rows: labels of values on the vertical axis, in place of numbers
        to_scale: whether both axes have the same scale, as for positions
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
    """One figure of a study, its panels one above the other.

    Args:
        name: identifier in the page: words joined by hyphens
        alternative: its content as text, for readers who cannot see it
    """

    name: str
    title: str
    caption: str
    alternative: str
    panels: tuple[Panel, ...]


Item = Heading | Table | Chart | Claim
"""One element of the content of a study, which is a sequence of these."""
