"""What commands do with an analysis: show it in the terminal, write its page, say how it came about."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tierod.report.analysis.analysis import Analysis
    from tierod.report.analysis.page import Facts, Origin


def refuse_to_overwrite(
    target: Path | None, given: Iterable[Path | str | None], what: str = "page", cure: str = "--output"
) -> None:
    """See that an output does not go where something lies, or will be written, that was given.

    Args:
        target: of the output
        given: what must stay
        what: the output is
        cure: option that names another place

    Raises:
        OutputError: it would
    """
    from tierod.core.errors import OutputError

    for path in given:
        if path and target is not None and Path(path).resolve() == target.resolve():
            raise OutputError(f"the {what} would overwrite {path}, which was given; name another place with {cure}")


def origin() -> Origin:
    """How what the running command makes came about: when, by which version, by which command."""
    import shlex
    import sys

    from tierod.report.analysis.page import Origin

    return Origin.now(shlex.join(["tierod", *sys.argv[1:]]))


def write_page(
    found: Analysis, facts: Facts, target: Path, not_good_for: Sequence[str] = (), kind: str = "analysis"
) -> None:
    """Write the page of an analysis; for its arguments see `tierod.report.analysis.page.render_analysis`.

    Raises:
        OutputError: it cannot be written
    """
    from tierod.core.files import write_text
    from tierod.report.analysis.page import render_analysis

    write_text(target, render_analysis(found, facts, origin(), not_good_for, kind))


def show(found: Analysis) -> None:
    """Summary and tables in the terminal."""
    from rich.text import Text

    from tierod.cli.terminal import output, rows
    from tierod.core.content import Table

    console = output()
    console.print(Text(found.title, style="bold"))
    for paragraph in (*found.summary, *(f"To know: {remark}" for remark in found.remarks)):
        console.print(Text(paragraph))
    for item in found.items:
        if isinstance(item, Table):
            console.print(Text(f"\n{item.title}", style="bold"))
            console.print(rows(item.header, item.rows, right=item.numeric))
            if item.note:
                console.print(Text(item.note))
