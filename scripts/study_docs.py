"""Write the claims of a study as a page of docs/reference/studies, those that do not hold first.

tierod study column -o OUT && python scripts/study_docs.py column OUT
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from docs_text import table

from tierod_lab.studies.registry import STUDIES

STUDY_PAGES = Path(__file__).resolve().parent.parent / "docs" / "reference" / "studies"
Claim = Mapping[str, Any]  # Entry of claims.json
QUICK = "This is of a quick run"  # Begin of the note of a claim whose run was `--quick`
QUICK_PAGE = "**The figures are those of a quick run** (`--quick`), over few and short drives: they are not reliable."
COUNTED = re.compile(
    r"^(\d+) claims: (\d+) hold, (\d+) do not, (\d+) of the source do not come out, (\d+) not measured", re.MULTILINE
)
OVERVIEW = (
    "# Claims of all studies",
    "<!-- Written by scripts/study_docs.py from the pages of the studies; do not edit. -->",
    "What the five papers and tierod claim, measured on virtual drives and real recordings. Every page states why each "
    "claim does not hold or come out, and what would mend it.",
)


def page(name: str, claims: Iterable[Claim]) -> str:
    judged = [claim for claim in claims if claim["goal"] is not None]
    missed = [claim for claim in judged if claim["met"] is False]
    outcomes = [claim["outcome"] for claim in judged]
    odd, unmeasured = outcomes.count("does not come out"), outcomes.count("not measured")
    counted = (
        f"{len(judged)} claims: {outcomes.count('holds')} hold, {len(missed) - odd} do not, {odd} of the source do not "
        f"come out, {unmeasured} not measured"
    )
    parts = [
        f"# {STUDIES[name].title}: claims",
        "<!-- Written by scripts/study_docs.py from claims.json of the study; do not edit. -->",
        *[QUICK_PAGE] * any(claim["note"].startswith(QUICK) for claim in judged),
        f"{STUDIES[name].summary} `tierod study {name}` measures them. "
        "[What the columns mean](../../how-to/run-studies.md).",
        counted,
    ]
    if missed:
        header = ("claim", "ours", "goal", "cause, and what would mend it", "id")
        causes, shared = _shared([each["cause"] for each in missed])
        rows = [
            [_sentence(each), *_figures(each), cause or "not known", f"`{each['id']}`"]
            for each, cause in zip(missed, causes, strict=True)
        ]
        parts += ["## What does not hold", table(header, rows), *shared]
    groups = STUDIES[name].groups
    for group in [*groups, *dict.fromkeys(_group(each) for each in judged if _group(each) not in groups)]:
        rows = [
            [_sentence(each), *_figures(each)] for each in judged if _group(each) == group and each["met"] is not False
        ]
        if rows:
            parts += [f"## {groups.get(group, group)}", table(("claim", "ours", "goal"), rows)]
    return "\n\n".join(parts) + "\n"


def _shared(causes: Sequence[str]) -> tuple[list[str], list[str]]:
    split = {cause: re.split(r"(?<=[.]) (?=[A-Z0-9])", cause) for cause in dict.fromkeys(causes)}
    for cause, number in Counter(causes).items():  # a cause that recurs as a whole is one entry
        if number > 1:
            split[cause] = [cause]
    counts = Counter(cause for each in causes for cause in split[each])
    often = [each for each, number in counts.items() if number > 1 and len(each.split()) > 6]
    short = [" ".join(f"[{often.index(x) + 1}]" if x in often else x for x in split[cause]) for cause in causes]
    listed = [f"- [{number}] {each}" for number, each in enumerate(often, 1)]
    return short, ["\n".join(["Causes that several of them share:", "", *listed])] if listed else []


def _group(claim: Claim) -> str:
    return str(claim["id"]).partition(".")[0]


def _sentence(claim: Claim) -> str:
    text, printed = str(claim["claim"]), claim["printed"]
    said = printed is None or re.search(rf"\b{re.escape(_number(printed))}\b", text)
    return text if said else f"{text} Printed: {_number(printed)}."


def _figures(claim: Claim) -> tuple[str, str]:
    unit = claim["unit"].replace("*", "·").replace("percent", "%")
    measured = "not measured" if claim["measured"] is None else f"{_number(claim['measured'])} {unit}".strip()
    return measured, str(claim["goal"]).replace(" ", "\N{NO-BREAK SPACE}")


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}".replace("-", "−")


def overview() -> str:
    rows, total = [], [0] * 5
    for name in STUDIES:
        text = (STUDY_PAGES / f"{name}.md").read_text(encoding="utf-8")
        numbers = [int(each) for each in COUNTED.findall(text)[0]]
        total = [before + each for before, each in zip(total, numbers, strict=True)]
        rows.append(
            [f"[{STUDIES[name].title}]({name}.md)", "quick" if QUICK_PAGE in text else "full", *map(str, numbers)]
        )
    rows.append(["**all**", "", *map(str, total)])
    header = ("study", "run", "claims", "hold", "do not hold", "of the source, do not come out", "not measured here")
    return "\n\n".join((*OVERVIEW, table(header, rows))) + "\n"


def main(name: str, folder: str) -> int:
    """Write the page from claims.json in a folder; returns the exit code."""
    if name not in STUDIES:
        print(f"there is no page of a study '{name}'; known: {', '.join(STUDIES)}", file=sys.stderr)
        return 1
    claims = json.loads((Path(folder) / "claims.json").read_text(encoding="utf-8"))
    (STUDY_PAGES / f"{name}.md").write_text(page(name, claims), encoding="utf-8")
    (STUDY_PAGES / "index.md").write_text(overview(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
