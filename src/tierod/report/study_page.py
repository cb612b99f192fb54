"""The page of a study: its claims first, then what they rest on, all in one file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tierod.core.claims import Claim
from tierod.core.content import Chart, Heading, Item, Table
from tierod.core.shown import written
from tierod.report.charts.figure import Figure
from tierod.report.charts.study import study_figure
from tierod.report.display import number
from tierod.report.html import chart_script, library, looks, moment, template


@dataclass(frozen=True)
class StudyPage:
    """All that a page of a study tells.

    Args:
        name, title, summary: of the study
        groups: title of every group of claims, in the order shown
        items: of the study, in order
        created, version, command: how the page came about
        remark: what holds for the whole page, such as that it was a quick run
    """

    name: str
    title: str
    summary: str
    groups: Mapping[str, str]
    items: Sequence[Item]
    created: str = ""
    version: str = ""
    command: str = ""
    remark: str = ""


@dataclass
class Section:
    """A part of a page: heading, paragraphs, and the tables and charts below it, each with its kind."""

    title: str
    text: tuple[str, ...]
    parts: list[tuple[str, Any]] = field(default_factory=list)


_PLURAL = {"holds": "hold", "does not hold": "do not hold", "not judged": "not judged"}
_VERDICTS = {True: ("✓", "holds", "good"), False: ("✕", "does not hold", "bad"), None: ("–", "not judged", "open")}


def render_study(page: StudyPage) -> str:
    """The page as text."""
    claims = [item for item in page.items if isinstance(item, Claim)]
    parts = sections(page.items)
    charts = [part for section in parts for kind, part in section.parts if kind == "chart"]
    return template("study.html.j2").render(
        page=page,
        created=moment(page.created),
        counts=[(*_VERDICTS[met], sum(claim.met is met for claim in claims)) for met in (True, False, None)],
        plural=_PLURAL,
        groups=[(title, rows) for title, rows in _groups(page.groups, claims) if rows],
        sections=parts,
        charts=[chart_script(figure) for figure in charts],
        library=library() if charts else "",
        **looks(),
    )


def _groups(titles: Mapping[str, str], claims: Sequence[Claim]) -> list[tuple[str, list[dict[str, Any]]]]:
    """(title, claims as shown) of every group; groups without a title stand last, under their name."""
    names = [*titles, *dict.fromkeys(claim.group for claim in claims if claim.group not in titles)]
    return [(titles.get(name, name), [_row(claim) for claim in claims if claim.group == name]) for name in names]


def _row(claim: Claim) -> dict[str, Any]:
    symbol, told, kind = _VERDICTS[claim.met]
    unit = written(claim.unit)
    return {
        "id": claim.id,
        "claim": claim.claim,
        "source": claim.source,
        "note": claim.note,
        "printed": _figure(claim.printed),
        "measured": _figure(claim.figure),
        "goal": "–" if claim.goal is None else str(claim.goal).replace("<=", "≤").replace(">=", "≥"),
        "unit": unit,
        "symbol": symbol,
        "told": told,
        "kind": kind,
    }


def _figure(value: float | str | None) -> str:
    return value if isinstance(value, str) else number(value, 4)


def sections(items: Sequence[Item]) -> list[Section]:
    """The items after their headings; claims stand elsewhere."""
    found = [Section("", ())]
    for item in items:
        if isinstance(item, Heading):
            found.append(Section(item.title, item.text))
        elif isinstance(item, Table):
            found[-1].parts.append(("table", item))
        elif isinstance(item, Chart):
            figure: Figure = study_figure(item)
            found[-1].parts.append(("chart", figure))
    return [section for section in found if section.title or section.parts]
