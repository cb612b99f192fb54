"""The page of an analysis, all in one file."""

from __future__ import annotations

from dataclasses import dataclass

from tierod.report.analysis.subjects import Analysis
from tierod.report.html import chart_script, library, looks, moment, template
from tierod.report.study_page import sections
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class Origin:
    """How a page came about.

    Args:
        created, version, command: when, by which version, and how
        recording: file that was measured; empty where there was none
    """

    created: str = ""
    version: str = ""
    command: str = ""
    recording: str = ""


def render_analysis(analysis: Analysis, vehicle: Vehicle, origin: Origin) -> str:
    """The page as text."""
    parts = sections(analysis.items)
    charts = [part for section in parts for kind, part in section.parts if kind == "chart"]
    facts = [("vehicle", vehicle.name), ("described as", vehicle.description), ("source", vehicle.source)]
    return template("analysis.html.j2").render(
        analysis=analysis,
        origin=origin,
        created=moment(origin.created),
        facts_of=facts + ([("recording", origin.recording)] if origin.recording else []),
        not_good_for=vehicle.not_good_for,
        sections=parts,
        charts=[chart_script(figure) for figure in charts],
        library=library() if charts else "",
        **looks(),
    )
