"""Result of an analysis, for terminal, page and JSON document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tierod.core.content import Item
from tierod.report.html import Origin, rendered, sections
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class Analysis:
    """Result of an analysis.

    Args:
        title: a few words
        summary: paragraphs with the main results
        items: headings, tables and charts in order; the terminal shows the tables
        document: the results as data in SI units, for JSON
        remarks: notices for a reader
    """

    title: str
    summary: tuple[str, ...]
    items: Sequence[Item]
    document: Mapping[str, Any]
    remarks: tuple[str, ...] = field(default=())


Facts = Sequence[tuple[str, str]]
"""Boundary conditions of an analysis, (name, text) each."""


def facts_of(vehicle: Vehicle) -> Facts:
    """Boundary conditions of the analysis of a vehicle."""
    return [("vehicle", vehicle.name), ("described as", vehicle.description), ("source", vehicle.source)]


def render_analysis(
    analysis: Analysis, facts: Facts, origin: Origin, not_good_for: Sequence[str] = (), kind: str = "analysis"
) -> str:
    """HTML page of an analysis."""
    return rendered(
        "analysis.html.j2",
        origin,
        sections=sections(analysis.items),
        title=analysis.title,
        summary=analysis.summary,
        remarks=analysis.remarks,
        kind=kind,
        facts_of=facts,
        not_good_for=not_good_for,
    )
