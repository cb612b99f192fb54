"""Contents of the five papers: where each equation, table and figure is implemented and tested in tierod."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tierod.core.errors import ParameterError
from tierod.core.toml import Document, build

PAPERS = ("friction", "condition", "column", "sideslip", "motor_angle")  # Names of the packages of the papers

_KINDS = {"Table": "table", "Tables": "table", "Figure": "figure", "Figures": "figure", "(": "equation"}
"""Kind of a part by the start of its name."""
_RANGE = re.compile(r"\(?(A?\d+)\)?(?: to \(?(\d+)\)?)?")
"""A number, of an appendix where it begins with A, or a range of numbers."""


@dataclass(frozen=True)
class Entry:
    """One row of the contents of a paper: some of its equations, tables or figures, or a section."""

    of: str  # the part, such as "(3), (4)", "(7) to (10)", "Table 2", "Figures 5, 6" or a section in words
    what: str  # subject of the part
    code: tuple[str, ...]  # "module:name" of every object that implements it
    verdict: str  # whether it is right as printed, and what was corrected

    @property
    def kind(self) -> str:
        """Kind of the part: "equation", "table", "figure", or "section" for all else."""
        return next((kind for word, kind in _KINDS.items() if self.of.startswith(word)), "section")

    @property
    def numbers(self) -> tuple[str, ...]:
        """Every number that the row covers, with ranges expanded; empty for a section."""
        if self.kind == "section":
            return ()
        found: list[str] = []
        for first, last in _RANGE.findall(self.of):
            found += [str(number) for number in range(int(first), int(last) + 1)] if last else [first]
        return tuple(found)


@dataclass(frozen=True)
class Contents:
    """Contents of one paper."""

    paper: str  # authors and subject
    explanation: str  # its page below docs/explanation/papers
    equations: int  # equations, tables, figures: number of each in the paper
    tables: int
    figures: int
    rows: tuple[Entry, ...]  # its parts, in the order of the paper

    def missing(self) -> tuple[str, ...]:
        """Numbered equations, tables and figures without a row, such as "equation 7"."""
        found = []
        for kind, count in (("equation", self.equations), ("table", self.tables), ("figure", self.figures)):
            known = {number for row in self.rows if row.kind == kind for number in row.numbers}
            found += [f"{kind} {number}" for number in range(1, count + 1) if str(number) not in known]
        return tuple(found)


@cache
def contents(package: str) -> Contents:
    """Read the contents of a paper from the file contents.toml of its package.

    Args:
        package: one of `PAPERS`

    Raises:
        ParameterError: there is no such paper, or its file is invalid
    """
    if package not in PAPERS:
        raise ParameterError(f"'{package}' is no paper; expected one of {', '.join(PAPERS)}")
    document = Document.read(Path(__file__).parent / package / "contents.toml")
    found: Contents = build(Contents, document.content, document)
    return found
