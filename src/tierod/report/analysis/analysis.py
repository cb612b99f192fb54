"""Result of an analysis, for terminal, page and JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tierod.core.content import Chart, Heading, Table

Shown = Heading | Table | Chart


@dataclass(frozen=True)
class Analysis:
    """What an analysis found.

    Args:
        title: a few words
        summary: paragraphs: what it comes to
        items: headings, tables and charts, one after the other; the terminal shows the tables
        document: the same as data, SI units, for JSON
        remarks: what a reader must know
        fits: whether the recording, where there is one, fits the model
    """

    title: str
    summary: tuple[str, ...]
    items: Sequence[Shown]
    document: Mapping[str, Any]
    remarks: tuple[str, ...] = field(default=())
    fits: bool = True
