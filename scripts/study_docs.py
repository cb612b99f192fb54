"""Write the claims of a study as a page of docs/reference/studies.

tierod study column | python scripts/study_docs.py column

The page holds the claims by group; tables and charts are in the report that the study writes. With the output folder
of the study as second argument, the claims are printed with their sentences from claims.json.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path

from docs_text import table

from tierod_lab.studies.registry import STUDIES

STUDY_PAGES = Path(__file__).resolve().parent.parent / "docs" / "reference" / "studies"
CAUSES = (
    "A claim of a paper does not come out where its figure contradicts the paper's own equations, or rests on numbers "
    "or data that it does not print; the cause is what shows that. Every other claim below is a shortfall of tierod."
)
TITLE = re.compile(r"^\*\*(.+)\*\*$")
PRINTED_BY = re.compile(r"^Printed by `(?P<command>.+)` of tierod (?P<version>\S+)\n?", re.MULTILINE)
CLAIMS, DESCRIBED, WHY = "Claims", "Figures of description", "What does not hold, and why"
PROGRESS = "measuring: "
"""Beginning of a progress line of the study, which is present if both outputs were redirected to one file."""
COUNTED = re.compile(
    r"^(\d+) claims: (\d+) hold, (\d+) do not(?:, (\d+) of the source do not come out)?(?:, (\d+) not measured)?.*$",
    re.MULTILINE,
)
OVERVIEW = (
    "# Claims of all studies",
    "<!-- Written by scripts/study_docs.py from the pages of the studies; do not edit. -->",
    "What the five papers and tierod claim, measured on virtual drives and real recordings. Every page states why each "
    "claim does not hold or come out, and what would mend it.",
)


def sections(printed: str) -> list[tuple[str, str]]:
    """(title, text below it) of all parts of a study's output."""
    found: list[tuple[str, list[str]]] = []
    for line in printed.splitlines():
        if title := TITLE.match(line):
            found.append((title[1], []))
        elif found and not line.startswith(PROGRESS):
            found[-1][1].append(line)
    return [(title, "\n".join(lines).strip()) for title, lines in found]


def page(name: str, printed: str, sentences: Mapping[str, str] | None = None) -> str:
    """Text of the page of a study.

    Args:
        name: of the study
        printed: output of the study
        sentences: identifier of a claim -> its sentence
    """
    by = PRINTED_BY.search(printed)
    every = dict(sections(PRINTED_BY.sub("", printed)))
    head = (
        f"# {STUDIES[name].title}: claims",
        f"<!-- Written by scripts/study_docs.py from what `tierod study {name}` prints; do not edit. -->",
        STUDIES[name].summary,
        f"{_origin(name, by)} [What the columns mean](../../how-to/run-studies.md).",
    )
    groups = _groups(name, every[CLAIMS], sentences or {})
    if WHY in every:
        groups.append(_causes(every[WHY]))
    if DESCRIBED in every:
        groups.append(_described(every[DESCRIBED], sentences or {}))
    counted = COUNTED.search(every[CLAIMS])
    return "\n\n".join((*head, *([counted[0]] if counted else []), *groups))


def _origin(name: str, by: re.Match[str] | None) -> str:
    """Command and version that measured the figures, as a sentence."""
    if by is None:
        return f"`tierod study {name}` measures these figures."
    quick = " It drives a few minutes only, so that figures of rare events say little." * ("--quick" in by["command"])
    return f"`{by['command']}` of tierod {by['version']} measured these figures.{quick}"


def _rows(printed: str) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a printed table."""
    lines = [line for line in printed.splitlines() if line[:1] == "|"]
    header, _, *rows = [[cell.strip() for cell in line[1:-1].split("|")] for line in lines]
    return header, rows


def _causes(printed: str) -> str:
    """Section of the claims that do not hold, with their causes."""
    header, rows = _rows(printed)
    return f"## {WHY}\n\n{CAUSES}\n\n" + table(header, [[f"`{row[0]}`", *row[1:]] for row in rows])


def _described(printed: str, sentences: Mapping[str, str]) -> str:
    """Section of the descriptive figures without claim, with their full names because groups are not separated."""
    header, rows = _rows(printed)
    cells = [[*([sentences.get(row[0], "")] if sentences else []), *row[1:], f"`{row[0]}`"] for row in rows]
    titles = (*(["figure"] if sentences else []), *header[1:], "id")
    return f"## {DESCRIBED}\n\nThese figures have no goal, so they cannot fail.\n\n" + table(titles, cells)


def _groups(name: str, listed: str, sentences: Mapping[str, str]) -> list[str]:
    """Sections of the printed table of claims, one per group, with the sentences of the claims where known."""
    titles, rows = _rows(listed)
    by_group: dict[str, list[list[str]]] = {}
    for row in rows:
        group, _, short = row[0].partition(".")
        sentence = [sentences[row[0]]] if row[0] in sentences else []
        row[titles.index("goal")] = row[titles.index("goal")].replace(" ", "\N{NO-BREAK SPACE}")
        by_group.setdefault(group, []).append([*sentence, *row[1:], f"`{short}`"])
    header = (*titles[1:], "id")
    return [
        f"## {STUDIES[name].groups.get(group, group)}\n\n"
        + table(("claim", *header) if len(members[0]) > len(header) else header, members)
        for group, members in by_group.items()
    ]


def overview() -> str:
    """Page with the number of claims of every study that hold, read from its pages."""
    rows, total = [], [0] * 5
    for name in STUDIES:
        counted = COUNTED.search((STUDY_PAGES / f"{name}.md").read_text(encoding="utf-8"))
        if counted is None:
            continue
        numbers = [int(each or 0) for each in counted.groups()]
        total = [before + each for before, each in zip(total, numbers, strict=True)]
        rows.append([f"[{STUDIES[name].title}]({name}.md)", *map(str, numbers)])
    rows.append(["**all**", *map(str, total)])
    header = ("study", "claims", "hold", "do not hold", "of the source, do not come out", "not measured here")
    return "\n\n".join((*OVERVIEW, table(header, rows))) + "\n"


def main(name: str, folder: str = "") -> int:
    """Write the page, provided that the input contains claims; returns the exit code."""
    if name not in STUDIES:
        print(f"there is no page of a study '{name}'; known: {', '.join(STUDIES)}", file=sys.stderr)
        return 1
    printed = sys.stdin.read()
    if CLAIMS not in dict(sections(printed)):
        print(f"standard input holds no list of claims; give what 'tierod study {name}' prints", file=sys.stderr)
        return 1
    claims = json.loads((Path(folder) / "claims.json").read_text(encoding="utf-8")) if folder else []
    sentences = {claim["id"]: claim["claim"] for claim in claims}
    STUDY_PAGES.mkdir(parents=True, exist_ok=True)
    (STUDY_PAGES / f"{name}.md").write_text(page(name, printed, sentences).rstrip() + "\n", encoding="utf-8")
    print(f"wrote docs/reference/studies/{name}.md")
    (STUDY_PAGES / "index.md").write_text(overview(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
