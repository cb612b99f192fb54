"""The page of a study: its claims first, then what they rest on, all in one file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tierod.core.claims import Claim
from tierod.core.content import Item
from tierod.core.shown import written
from tierod.report.display import number
from tierod.report.html import Origin, rendered, sections


@dataclass(frozen=True)
class StudyPage:
    """Content of the page of a study.

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


_PLURAL = {"holds": "hold", "does not hold": "do not hold", "not measured": "not measured"}
_VERDICTS = {True: ("✓", "holds", "good"), False: ("✕", "does not hold", "bad"), None: ("–", "not measured", "open")}


def render_study(page: StudyPage) -> str:
    """The page as text."""
    every = [item for item in page.items if isinstance(item, Claim)]
    claims, described = ([claim for claim in every if claim.describes is only] for only in (False, True))
    return rendered(
        "study.html.j2",
        Origin(page.created, page.version, page.command),
        sections=sections(page.items),
        page=page,
        counts=[(*_VERDICTS[met], sum(claim.met is met for claim in claims)) for met in (True, False, None)],
        plural=_PLURAL,
        groups=[(title, rows) for title, rows in _groups(page.groups, claims) if rows],
        described=[_row(claim) for claim in described],
        derived=any(claim.derived is not None for claim in claims),
    )


def _groups(titles: Mapping[str, str], claims: Sequence[Claim]) -> list[tuple[str, list[dict[str, Any]]]]:
    """(title, claims as shown) of every group; groups without a title stand last, under their name."""
    names = [*titles, *dict.fromkeys(claim.group for claim in claims if claim.group not in titles)]
    return [(titles.get(name, name), [_row(claim) for claim in claims if claim.group == name]) for name in names]


def _row(claim: Claim) -> dict[str, Any]:
    symbol, word, kind = _VERDICTS[claim.met]
    unit = written(claim.unit)
    return {
        "id": claim.id,
        "claim": claim.claim,
        "source": claim.source,
        "note": claim.note,
        "printed": _figure(claim.printed),
        "derived": "" if claim.derived is None else _figure(claim.derived),
        "measured": _figure(claim.figure),
        "goal": "–" if claim.goal is None else str(claim.goal).replace("<=", "≤").replace(">=", "≥"),
        "unit": unit,
        "symbol": symbol,
        "word": word,
        "kind": kind,
    }


def _figure(value: float | str | None) -> str:
    return value if isinstance(value, str) else number(value, 4)
