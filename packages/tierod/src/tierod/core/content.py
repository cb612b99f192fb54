"""Items of every report, as plain data: verdicts, headings, tables, charts, facts and folds.

One compiler makes pages of them, `tierod.report.html`, and one prints them in a terminal, `tierod.report.terminal`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.core.claims import Claim
from tierod.core.findings import Estimate
from tierod.core.statuses import COLOURS, Status

Numbers = Sequence[float] | np.ndarray


@dataclass(frozen=True)
class Heading:
    """Heading of a section, with its introduction."""

    title: str
    text: tuple[str, ...] = ()
    look: str = ""  # CSS class of the section: "pair" for two charts beside each other, "together" on one printed page


class Flag(str):
    """A word with a symbol and a colour, such as the result of a gate; it is shown like a status."""

    symbol: str
    colour: str

    def __new__(cls, word: str, symbol: str, colour: str) -> Flag:
        made = super().__new__(cls, word)
        made.symbol, made.colour = symbol, colour
        return made

    @property
    def capitals(self) -> str:
        return f"{self.symbol} {self.upper()}"

    @property
    def style(self) -> str:
        return COLOURS.get(self.colour, "")


class Link(str):
    """A cell that leads to a file beside the page."""

    address: str

    def __new__(cls, text: str, address: str) -> Link:
        made = super().__new__(cls, text)
        made.address = address
        return made


@dataclass(frozen=True)
class Verdict:
    """The statement that a page or a part of it begins with."""

    headline: str  # as assembled; nothing is added to it
    status: Status | Flag | None = None
    about: tuple[tuple[str, str], ...] = ()  # what was judged, shown beside the status
    text: tuple[str, ...] = ()  # paragraphs below the headline
    estimate: Estimate | None = None
    reasons: tuple[tuple[str, str], ...] = ()  # titles with sentences: why, what to do, to know
    evidence: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Facts:
    """Names with values; a page folds all but the first ones."""

    rows: Sequence[tuple[str, str]]
    title: str = ""


@dataclass(frozen=True)
class Fold:
    """Items under a title that opens them; a terminal leaves them out."""

    title: str
    items: Sequence[Any]  # neither headings nor verdicts
    text: tuple[str, ...] = ()  # paragraphs before them
    printed: bool = True  # whether a printed page shows the title and, where it is open, the items
    opened: bool = False


@dataclass(frozen=True)
class Table:
    title: str  # meaning of the figures, a sentence without full stop, with the unit; "" for that of the section
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]  # cells as text; the first one names the row
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
    """Boxes at named places: quartiles with the median, and whiskers from a low to a high quantile."""

    name: str
    places: Sequence[str]
    low: Numbers
    lower: Numbers
    median: Numbers
    upper: Numbers
    high: Numbers

    @classmethod
    def normal(cls, name: str, places: Sequence[str], mean: Numbers, deviation: Numbers) -> Boxes:
        """Boxes of one standard deviation, with whiskers of two."""
        middle, spread = np.asarray(mean, float), np.asarray(deviation, float)
        ends = (middle + factor * spread for factor in (-2.0, -1.0, 0.0, 1.0, 2.0))
        return cls(name, places, *ends)


@dataclass(frozen=True, eq=False)
class Cells:
    """Table of shares as colours (such as a confusion matrix), alone in its panel."""

    name: str
    down: Sequence[str]
    across: Sequence[str]
    shares: np.ndarray  # 0 to 1, (rows, columns); NaN leaves a cell empty


Mark = Lines | Bars | Points | Band | Boxes | Cells


@dataclass(frozen=True)
class Panel:
    """One panel of a chart with axes of its own."""

    title: str
    x_title: str
    y_title: str
    marks: tuple[Mark, ...]  # the drawn series; a name that two panels share has the same colour in both
    levels: tuple[tuple[str, float], ...] = ()  # horizontal dashed lines at named values
    uprights: tuple[tuple[str, float], ...] = ()
    logarithmic: bool = False  # whether the vertical axis is logarithmic
    logarithmic_along: bool = False  # whether the horizontal axis is logarithmic
    # whether the named places of points are listed from top to bottom and their values run to the right, for many
    # places with long names. The titles of the axes and the levels stay with their values
    sideways: bool = False
    rows: tuple[tuple[str, float], ...] = ()  # labels of values on the vertical axis, in place of numbers
    to_scale: bool = False  # whether both axes have the same scale, as for positions


@dataclass(frozen=True)
class Chart:
    """One figure of a study, its panels one above the other."""

    name: str  # identifier in the page: words joined by hyphens
    title: str
    caption: str
    alternative: str  # its content as text, for readers who cannot see it
    panels: tuple[Panel, ...]
    # table below the chart; where not given, lowest, mean and highest value of every mark
    columns: tuple[str, str, str, str] = ("series", "lowest", "mean", "highest")
    summary: tuple[tuple[str, ...], ...] | None = None
    shared_axes: bool = False  # whether all panels have the same scales


Item = Verdict | Heading | Table | Chart | Facts | Fold | Claim  # One element of a report, which is a sequence of these
