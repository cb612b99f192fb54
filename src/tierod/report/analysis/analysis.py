"""Result of an analysis, for terminal, page and JSON."""

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
        summary: paragraphs: what it comes to
        items: headings, tables and charts, one after the other; the terminal shows the tables
        document: the same as data, SI units, for JSON
        remarks: notices for a reader
        fits: whether the recording, where there is one, fits the model
    """

    title: str
    summary: tuple[str, ...]
    items: Sequence[Item]
    document: Mapping[str, Any]
    remarks: tuple[str, ...] = field(default=())
    fits: bool = True


Facts = Sequence[tuple[str, str]]
"""What an analysis rests on, (name, text) each."""


def facts_of(vehicle: Vehicle, recording: str = "") -> Facts:
    """Facts that an analysis of a vehicle rests on.

    Args:
        vehicle: whose parameters they are
        recording: file that was measured; empty where there was none
    """
    facts = [("vehicle", vehicle.name), ("described as", vehicle.description), ("source", vehicle.source)]
    return facts + ([("recording", recording)] if recording else [])


def render_analysis(
    analysis: Analysis, facts: Facts, origin: Origin, not_good_for: Sequence[str] = (), kind: str = "analysis"
) -> str:
    """The page as text.

    Args:
        analysis: what was found
        facts: what it rests on
        origin: how the page came about
        not_good_for: what the parameters are not good for
        kind: of the page, in a word
    """
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
