"""Page of a study: claims first, then their evidence, in one file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tierod.core.claims import Claim, Outcome
from tierod.core.content import Item
from tierod.core.shown import written
from tierod.report.charts.figure import Figure
from tierod.report.display import number
from tierod.report.html import Origin, Section, rendered, sections


@dataclass(frozen=True)
class StudyPage:
    """Content of the page of a study.

    Args:
        name, title, summary: of the study
        groups: titles of the groups of claims, in the order shown
        items: contents of the study, in order
        created, version, command: origin of the page
        remark: on the whole page, such as that it was a quick run
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


_PLURAL = {
    Outcome.HOLDS: "hold",
    Outcome.FAILS: "do not hold",
    Outcome.IRREPRODUCIBLE: "do not come out",
    Outcome.UNMEASURED: "not measured",
}
_VERDICTS = {
    Outcome.HOLDS: ("✓", "good"),
    Outcome.FAILS: ("✕", "bad"),
    Outcome.IRREPRODUCIBLE: ("✕", "open"),
    Outcome.UNMEASURED: ("–", "open"),
}


def render_study(page: StudyPage) -> str:
    every = [item for item in page.items if isinstance(item, Claim)]
    claims, described = ([claim for claim in every if claim.describes is only] for only in (False, True))
    picture, parts = _picture(sections(page.items))
    return rendered(
        Path(__file__).with_name("study.html.j2"),
        Origin(page.created, page.version, page.command),
        [picture] if picture else [],
        sections=parts,
        page=page,
        picture=picture,
        counts=_counts(claims),
        plural=_PLURAL,
        groups=[_group(title, members) for title, members in _groups(page.groups, claims) if members],
        described=[_row(claim) for claim in described],
        derived=any(claim.derived is not None for claim in claims),
    )


def _picture(parts: Sequence[Section]) -> tuple[Figure | None, list[Section]]:
    part = next((part for section in parts for part in section.parts if part[0] == "chart"), None)
    rest = [replace(section, parts=[each for each in section.parts if each is not part]) for section in parts]
    return (part[1] if part else None), [section for section in rest if section.text or section.parts]


def _groups(titles: Mapping[str, str], claims: Sequence[Claim]) -> list[tuple[str, list[Claim]]]:
    names = [*titles, *dict.fromkeys(claim.group for claim in claims if claim.group not in titles)]
    return [(titles.get(name, name), [claim for claim in claims if claim.group == name]) for name in names]


def _group(title: str, claims: Sequence[Claim]) -> dict[str, Any]:
    counts = [(word, count) for _, word, _, count in _counts(claims)]
    return {
        "title": title,
        "open": any(claim.met is False for claim in claims),
        "counts": ", ".join(f"{count} {word if count == 1 else _PLURAL[word]}" for word, count in counts if count),
        "rows": [_row(claim) for claim in claims],
    }


def _counts(claims: Sequence[Claim]) -> list[tuple[str, Outcome, str, int]]:
    """(symbol, outcome, kind, number) of every outcome; irreproducible claims only where there are any."""
    found = [(*_VERDICTS[each], each, sum(claim.outcome is each for claim in claims)) for each in Outcome]
    return [(a, each, b, n) for a, b, each, n in found if n or each is not Outcome.IRREPRODUCIBLE]


def _row(claim: Claim) -> dict[str, Any]:
    word = claim.outcome or Outcome.UNMEASURED
    symbol, kind = _VERDICTS[word]
    unit = written(claim.unit)
    return {
        "id": claim.id,
        "claim": claim.claim,
        "source": claim.source,
        "note": claim.note,
        "cause": claim.cause if claim.met is False else "",
        "printed": _figure(claim.printed),
        "derived": "" if claim.derived is None else _figure(claim.derived),
        "measured": _figure(claim.figure),
        "goal": "–" if claim.goal is None else str(claim.goal).replace("<=", "≤").replace(">=", "≥").replace("-", "−"),
        "unit": unit,
        "symbol": symbol,
        "word": word,
        "kind": kind,
    }


def _figure(value: float | str | None) -> str:
    return value if isinstance(value, str) else number(value, 4)
