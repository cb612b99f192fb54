"""Reference page of the five papers: what of their equations, tables and figures was corrected or left open."""

from __future__ import annotations

from collections.abc import Callable

from docs_text import page, table

from tierod_lab.papers.contents import PAPERS, Contents, contents

AS_PRINTED = ("right", "redrawn", "nothing to reproduce", "both run", "as many minutes")
"""Beginnings of the verdicts on parts that are carried out as printed."""


def pages() -> dict[str, Callable[[], str]]:
    """Path below docs/ -> function that returns the text."""
    return {"reference/papers.md": papers}


def papers() -> str:
    """Page with the number of implemented parts of each paper, and with those that differ from the print."""
    held = [contents(package) for package in PAPERS]
    rows = [(f"[{each.paper}](../explanation/papers/{each.explanation}.md)", *map(str, _counts(each))) for each in held]
    parts = [
        "tierod carries out every numbered equation, table and figure of five papers. The `contents.toml` of each "
        "package of `tierod_lab.papers` names the function of each; a test requires that none is missing. "
        "`tierod study NAME` measures the claims.",
        table(("paper, and what is corrected why", "equations", "tables", "figures", "misprints"), rows),
    ]
    for each in held:
        differing = [row for row in each.rows if not row.verdict.startswith(AS_PRINTED)]
        shown = [(row.of, row.what, row.verdict) for row in differing]
        parts += [f"## {each.paper}", table(("part that differs from the print", "what", "verdict"), shown)]
    return page("The five papers", *parts)


def _counts(held: Contents) -> tuple[int, ...]:
    misprints = sum("misprint" in row.verdict for row in held.rows)
    return held.equations, held.tables, held.figures, misprints
