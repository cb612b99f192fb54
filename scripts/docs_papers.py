"""Reference page of the five papers: how much of each is carried out, and how much was misprinted."""

from __future__ import annotations

from collections.abc import Callable

from docs_text import page, table

from tierod_lab.papers.contents import PAPERS, contents


def pages() -> dict[str, Callable[[], str]]:
    """Path below docs/ -> function that returns the text."""
    return {"reference/papers.md": papers}


def papers() -> str:
    """Page with the number of implemented and of misprinted parts of each paper."""
    rows = []
    for package in PAPERS:
        held = contents(package)
        misprints = sum("misprint" in row.verdict for row in held.rows)
        gaps = sum("gap" in row.verdict for row in held.rows)
        counts = (str(number) for number in (held.equations, held.tables, held.figures, misprints, gaps))
        rows.append((f"[{held.paper}](../explanation/papers/{held.explanation}.md)", *counts))
    return page(
        "The five papers",
        "tierod carries out every numbered equation, table and figure of five papers; their pages explain what is "
        "corrected. In the repository `contents.toml` of each package of `tierod_lab.papers` names, for every number, "
        "the function that implements it and what differs from the print; a test requires that none is missing.",
        table(("paper", "equations", "tables", "figures", "parts with misprints", "with gaps"), rows),
        "[Claims of the papers, measured](studies/index.md).",
    )
