"""Reference pages of the five papers: every equation, table and figure with its location in the code."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from docs_text import page, table

from tierod_lab.papers.contents import PAPERS, Entry, contents


def pages() -> dict[str, Callable[[], str]]:
    """Path below docs/ -> function that returns the text."""
    found: dict[str, Callable[[], str]] = {"reference/papers/index.md": overview}
    return found | {f"reference/papers/{_file(package)}.md": partial(paper, package) for package in PAPERS}


def _file(package: str) -> str:
    return package.replace("_", "-")


def overview() -> str:
    """Page with the number of implemented items of each paper."""
    rows = []
    for package in PAPERS:
        held = contents(package)
        misprints = sum("misprint" in row.verdict for row in held.rows)
        rows.append(
            (
                f"[{held.paper}]({_file(package)}.md)",
                *(str(count) for count in (held.equations, held.tables, held.figures)),
                str(misprints),
                f"[page](../../explanation/papers/{held.explanation}.md)",
            )
        )
    return page(
        "The five papers",
        "Every numbered equation, table and figure of the papers that tierod carries out: where it is implemented, and "
        "what was corrected. A test requires that every number is covered and every named function exists.",
        table(("paper", "equations", "tables", "figures", "entries with misprints", "explanation"), rows),
    )


def paper(package: str) -> str:
    """Page of one paper."""
    held = contents(package)
    return page(
        held.paper,
        f"[What is corrected and why](../../explanation/papers/{held.explanation}.md). `tierod study {_file(package)}` "
        "measures its claims.",
        table(("of the paper", "what", "implemented in", "verdict"), map(_row, held.rows)),
    )


def _row(entry: Entry) -> tuple[str, ...]:
    code = ", ".join(f"`{each.replace(':', '.').removeprefix('tierod.')}`" for each in entry.code)
    return entry.of, entry.what, code, entry.verdict
