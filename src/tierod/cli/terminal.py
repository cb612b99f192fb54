"""What commands share: the two consoles, JSON on stdout, and progress on anything longer than a second."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from tierod.cli.visible import console, say, visible

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

PATIENCE = 1.0
"""Seconds of silence before a progress bar appears."""

PIPED_WIDTH = 120
"""Columns where the output is no terminal and has no width of its own."""


def output() -> Console:
    """The console of stdout: what was asked for."""
    return console(stderr=False, width=None if sys.stdout.isatty() else PIPED_WIDTH)


def messages() -> Console:
    """The console of stderr: progress and remarks."""
    return console(stderr=True, width=None if sys.stderr.isatty() else PIPED_WIDTH)


def rows(titles: Sequence[str], cells: Iterable[Sequence[str]], right: Sequence[int] = ()) -> Table:
    """A plain table.

    Args:
        titles: of the columns
        cells: the rows; square brackets are text, not markup, also in titles
        right: the columns that hold numbers
    """
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    for index, title in enumerate(titles):
        table.add_column(Text(visible(title)), justify="right" if index in right else "left", overflow="fold")
    for row in cells:
        table.add_row(*(Text(visible(cell)) for cell in row))
    return table


def print_json(document: Any) -> None:
    """One JSON document to stdout; numbers that JSON cannot hold become null.

    Args:
        document: nested dictionaries, lists, strings and numbers; or a text that is JSON already
    """
    text = document if isinstance(document, str) else json.dumps(finite(document), ensure_ascii=False, indent=2)
    say(text.rstrip("\n"))


def finite(document: Any) -> Any:
    """The document with NaN and infinity replaced by None."""
    if isinstance(document, dict):
        return {key: finite(value) for key, value in document.items()}
    if isinstance(document, list | tuple):
        return [finite(value) for value in document]
    if isinstance(document, float) and not math.isfinite(document):
        return None
    return document


@contextmanager
def progress(description: str) -> Iterator[Callable[[float], None]]:
    """A function to be called with the share done (0 to 1); a bar appears on stderr if it takes longer than a second.

    Args:
        description: what is being done, in a few words
    """
    began, bar, task = time.monotonic(), None, None

    def advance(share: float) -> None:
        nonlocal bar, task
        if bar is None and sys.stderr.isatty() and time.monotonic() - began > PATIENCE:
            from rich.markup import escape
            from rich.progress import Progress

            bar = Progress(console=messages(), transient=True)
            task = bar.add_task(escape(description), total=1.0)
            bar.start()
        if bar is not None and task is not None:
            bar.update(task, completed=share)

    try:
        yield advance
    finally:
        if bar is not None:
            bar.stop()
