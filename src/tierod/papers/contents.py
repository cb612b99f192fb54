"""Contents of the five papers, and where each equation, table and figure is found in tierod."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tierod.core.errors import ParameterError
from tierod.core.toml import Document, build

PAPERS = ("friction", "condition", "column", "sideslip", "motor_angle")
"""Packages of the papers."""

_KINDS = {"Table": "table", "Tables": "table", "Figure": "figure", "Figures": "figure", "(": "equation"}
_RANGE = re.compile(r"\(?(A?\d+)\)?(?: to \(?(\d+)\)?)?")


@dataclass(frozen=True)
class Entry:
    """A part of a paper.

    Args:
        of: "(3), (4)", "(7) to (10)", "Table 2", "Figures 5, 6" or a section in words
        what: it is about
        code: "module:name" of all that carries it out
        tests: files of tests
        study: "package.module" of the parts of the studies that reproduce it
        verdict: whether it is right as printed, and what was corrected
    """

    of: str
    what: str
    code: tuple[str, ...]
    tests: tuple[str, ...]
    study: tuple[str, ...]
    verdict: str

    @property
    def kind(self) -> str:
        """ "equation", "table", "figure", or "section" for all else."""
        return next((kind for word, kind in _KINDS.items() if self.of.startswith(word)), "section")

    @property
    def numbers(self) -> tuple[str, ...]:
        """Every number that it stands for, ranges spelt out; none of a section."""
        if self.kind == "section":
            return ()
        found: list[str] = []
        for first, last in _RANGE.findall(self.of):
            found += [str(number) for number in range(int(first), int(last) + 1)] if last else [first]
        return tuple(found)


@dataclass(frozen=True)
class Contents:
    """A paper.

    Args:
        paper: authors and subject
        explanation: page below docs/explanation/papers
        equations, tables, figures: how many it numbers
        rows: its parts, in its order
    """

    paper: str
    explanation: str
    equations: int
    tables: int
    figures: int
    rows: tuple[Entry, ...]

    def missing(self) -> tuple[str, ...]:
        """Numbered parts without a row, in words."""
        found = []
        for kind, count in (("equation", self.equations), ("table", self.tables), ("figure", self.figures)):
            known = {number for row in self.rows if row.kind == kind for number in row.numbers}
            found += [f"{kind} {number}" for number in range(1, count + 1) if str(number) not in known]
        return tuple(found)


@cache
def contents(package: str) -> Contents:
    """Contents of a paper.

    Args:
        package: one of `PAPERS`

    Raises:
        ParameterError: there is none, or its file is wrong
    """
    if package not in PAPERS:
        raise ParameterError(f"'{package}' is no paper; expected one of {', '.join(PAPERS)}")
    document = Document.read(Path(__file__).parent / package / "contents.toml")
    found: Contents = build(Contents, document.content, document)
    return found
