"""Page of a study: claims first, then their evidence, in one file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from tierod.core.claims import Claim, Outcome
from tierod.core.content import Chart, Flag, Fold, Heading, Item, Table, Verdict
from tierod.core.shown import written
from tierod.report.display import number
from tierod.report.html import Origin, page

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


@dataclass(frozen=True)
class StudyPage:
    """Content of the page of a study."""

    name: str
    title: str
    summary: str
    groups: Mapping[str, str]  # titles of the groups of claims, in the order shown
    items: Sequence[Item]
    origin: Origin = field(default_factory=Origin)
    remark: str = ""  # on the whole page, such as that it was a quick run


def render_study(study: StudyPage) -> str:
    note = (
        "The same claims stand in claims.json beside this page. What names no recording was measured on virtual cars; "
        "whether a claim holds follows from the figure and the goal beside it."
    )
    came = [Heading("Provenance", (note,))]
    return page(_items(study), study.origin, f"Study: {study.title}", f"study {study.name}", came=came)


def _items(study: StudyPage) -> Iterator[Item]:
    every = [item for item in study.items if isinstance(item, Claim)]
    claims, described = ([claim for claim in every if claim.describes is only] for only in (False, True))
    remark = (("To know", study.remark),) if study.remark else ()
    yield Verdict(study.title, None, (), (study.summary, f"{_counts(claims)}."), None, remark)
    picture = next((item for item in study.items if isinstance(item, Chart)), None)
    if picture:
        yield picture
    if every:
        yield Heading("Claims")
    derived = any(claim.derived is not None for claim in claims)
    for title, members in _groups(study.groups, claims):
        missed = any(claim.met is False for claim in members)
        yield Fold(f"{title}: {_counts(members)}", [_table(title, members, derived)], opened=missed)
    if described:
        rows = tuple(
            (_named(each), _figure(each.printed), _figure(each.figure), written(each.unit)) for each in described
        )
        header = ("figure", "printed", "ours", "unit")
        yield Table("Figures of description", header, rows, "These figures have no goal, so they cannot fail.")
    yield from (item for item in study.items if item is not picture and not isinstance(item, Claim))


def _groups(titles: Mapping[str, str], claims: Sequence[Claim]) -> Iterator[tuple[str, list[Claim]]]:
    for name in dict.fromkeys((*titles, *(claim.group for claim in claims))):
        if members := [claim for claim in claims if claim.group == name]:
            yield titles.get(name, name), members


def _counts(claims: Sequence[Claim]) -> str:
    """Number of claims of every outcome; of irreproducible ones only where there are any."""
    counts = {each: sum(claim.outcome is each for claim in claims) for each in Outcome}
    shown = [(each, n) for each, n in counts.items() if n or each is not Outcome.IRREPRODUCIBLE]
    return ", ".join(f"{n} {each if n == 1 else _PLURAL[each]}" for each, n in shown)


def _table(title: str, claims: Sequence[Claim], derived: bool) -> Table:
    header = ("claim", "holds", "printed", *(("derived",) if derived else ()), "ours", "goal", "unit")
    rows = []
    for claim in claims:
        outcome = claim.outcome or Outcome.UNMEASURED
        own = ("" if claim.derived is None else _figure(claim.derived),) if derived else ()
        goal = str(claim.goal).replace("<=", "≤").replace(">=", "≥").replace("-", "−")
        figures = (_figure(claim.printed), *own, _figure(claim.figure), goal, written(claim.unit))
        rows.append((_named(claim), Flag(outcome, *_VERDICTS[outcome]), *figures))
    return Table(title, header, tuple(rows))


def _named(claim: Claim) -> str:
    cause = f"Cause: {claim.cause}" if claim.cause and claim.met is False else ""
    return " ".join(filter(None, (claim.claim, f"({claim.source})", claim.note, cause)))


def _figure(value: float | str | None) -> str:
    return value if isinstance(value, str) else number(value, 4)
