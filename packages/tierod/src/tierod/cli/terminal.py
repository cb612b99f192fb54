"""Common parts of commands: consoles that print control characters as escapes, JSON, progress, pages of analyses."""

from __future__ import annotations

import codecs
import contextlib
import json
import re
import shlex
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from tierod.core.content import Item
    from tierod.report.charts.figure import Figure
    from tierod.report.html import Analysis, Origin


UNSHOWN = "tierod.unshown"
"""Name of the error handler of streams that replaces characters missing in their encoding by escapes."""

_STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def visible(text: str) -> str:
    """The text with control characters, bidirectional controls and surrogates as escapes such as \\u001b.

    Line ends and tabs are kept. A JSON parser turns the escapes back into the characters.
    """
    return _STEERING.sub(lambda found: _spelt(found[0]), text)


def say(text: str, end: str = "\n") -> None:
    """Print a text to stdout, with control characters as escapes."""
    print(visible(text), end=end)


def spell_what_cannot_be_shown() -> None:
    """Make stdout and stderr print escapes for characters missing in their encoding, where printing would raise."""
    codecs.register_error(UNSHOWN, _spell)
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, ValueError):  # the stream was replaced by another object
            stream.reconfigure(errors=UNSHOWN)  # type: ignore[union-attr]


def console(stderr: bool, width: int | None) -> Console:
    """A console that prints control characters of texts as escapes."""
    from rich.console import Console
    from rich.segment import Segment

    class _Console(Console):
        # All printing passes through this method, including that of other libraries.
        def _render_buffer(self, buffer):  # type: ignore[no-untyped-def]
            shown = (part if part.control else Segment(visible(part.text), part.style) for part in buffer)
            return super()._render_buffer(shown)

    return _Console(stderr=stderr, highlight=False, width=width)


def _spell(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_spelt, error.object[error.start : error.end])), error.end


def _spelt(letter: str) -> str:
    units = letter.encode("utf-16-be", "surrogatepass")
    return "".join(f"\\u{units[place : place + 2].hex()}" for place in range(0, len(units), 2))


PATIENCE = 1.0  # Time before a progress bar appears [s]

QUIET_SECONDS = 10.0  # Shortest time between two lines of progress if stderr is no terminal [s]

PIPED_WIDTH = 120  # Width of the output in columns if it is no terminal


def output() -> Console:
    return console(stderr=False, width=None if sys.stdout.isatty() else PIPED_WIDTH)


def messages() -> Console:
    """The console of stderr, for progress and remarks."""
    return console(stderr=True, width=None if sys.stderr.isatty() else PIPED_WIDTH)


def print_remark(text: str) -> None:
    """Print a line for the user to stderr, wrapped by the terminal alone; square brackets are text."""
    messages().print(text, soft_wrap=True, markup=False)


def rows(titles: Sequence[str], cells: Iterable[Sequence[str]], right: Sequence[int] = ()) -> Table:
    """A plain table, see `tierod.report.terminal.rows`."""
    from tierod.report.terminal import rows

    return rows(titles, cells, right)


def show(items: Iterable[Item | Figure]) -> None:
    """Print the items of a report to stdout."""
    from tierod.report.terminal import show

    show(items, output())


def say_where(as_json: bool, what: str, path: object) -> None:
    """Print the path of a file that was written, to stderr beside a JSON document."""
    (messages() if as_json else output()).print(f"{what}: {path}", soft_wrap=True, markup=False)


def print_json(document: Any) -> None:
    """Print one JSON document to stdout; values that JSON cannot represent become null."""
    from tierod.report.document import plain

    text = document if isinstance(document, str) else json.dumps(plain(document), ensure_ascii=False, indent=2)
    say(text.rstrip("\n"))


@contextmanager
def progress(description: str) -> Iterator[Callable[[float], None]]:
    """Function to be called with the share done (0 to 1); after a second a bar appears if stderr is a terminal."""
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


class Counting:
    """Number of finished drives or recordings on the terminal: a bar if there is one, else occasional lines.

    Args:
        name: title of the lines, and of the bar from the first count on; "" for none
        bar: update of the bar; None where there is none
    """

    def __init__(self, console: Console, what: str, name: str, bar: Callable[..., None] | None = None):
        self._console, self._what, self._name, self._bar = console, what, name, bar
        self._last, self.done, self.total = -QUIET_SECONDS, 0, 0

    def show(self, done: int, total: int) -> None:
        """Show how many are finished, in a line only after `QUIET_SECONDS` or at the end."""
        self.done, self.total, now = done, total, time.monotonic()
        if self._bar is not None:
            self._bar(completed=done, total=total, description=self._name.replace("[", "\\[") or None)
        elif now - self._last >= QUIET_SECONDS or done >= total:
            from tierod.core.shown import counted

            self._last = now
            title = f"{self._name}: " if self._name else ""
            self.say(f"{title}{done} of {counted(total, self._what.removesuffix('s'))}")

    def say(self, text: str) -> None:
        """Print a line at once."""
        self._console.print(text, soft_wrap=True, markup=False)


@contextmanager
def counting(what: str, begin: str, name: str = "", total: int | None = None) -> Iterator[Counting]:
    """Count of finished drives or recordings: a bar if stderr is a terminal, else occasional lines."""
    if not sys.stderr.isatty():
        yield Counting(messages(), what, name)
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), TimeRemainingColumn(), console=messages(), transient=True) as bar:
        task = bar.add_task(begin, total=total)
        yield Counting(bar.console, what, name, partial(bar.update, task))


def report_path(output: Path | None, wanted: bool, usual: str) -> Path | None:
    """Path of the report to write; None if none is wanted."""
    from tierod.core.errors import ParameterError

    if output is not None and not wanted:
        raise ParameterError(f"--no-report and --output {output} exclude each other; leave one of them out")
    return (output or Path(usual)) if wanted else None


def refuse_to_overwrite(
    target: Path | None, given: Iterable[Path | str | None], what: str = "page", cure: str = "--output"
) -> None:
    """Check that an output does not overwrite an input or another output."""
    from tierod.core.errors import OutputError

    for path in given:
        if path and target is not None and Path(path).resolve() == target.resolve():
            raise OutputError(f"the {what} would overwrite {path}, which was given; name another place with {cure}")


def command_line() -> str:
    """The running command as it was typed."""
    return shlex.join(["tierod", *sys.argv[1:]])


def origin() -> Origin:
    """Provenance of the running command's output: time, version and command line."""
    from tierod.report.html import Origin

    return Origin.now(command_line())


def write_page(
    found: Analysis,
    facts: Sequence[tuple[str, str]],
    target: Path,
    not_good_for: Sequence[str] = (),
    kind: str = "analysis",
) -> None:
    """Write the page of an analysis; for the arguments see `tierod.report.html.render_analysis`."""
    from tierod.core.files import write_text
    from tierod.report.html import render_analysis

    write_text(target, render_analysis(found, facts, origin(), not_good_for, kind))


def present(
    found: Analysis,
    document: Mapping[str, Any],
    as_json: bool,
    target: Path | None,
    facts: Sequence[tuple[str, str]],
    not_good_for: Sequence[str] = (),
    kind: str = "analysis",
) -> None:
    if target is not None:
        write_page(found, facts, target, not_good_for, kind)
    if as_json:
        print_json(document)
    else:
        show_analysis(found)
    if target is not None:
        say_where(as_json, "page", target)


def show_analysis(found: Analysis) -> None:
    """Print summary and tables of an analysis."""
    from tierod.core.content import Table

    show([found.head, *(item for item in found.items if isinstance(item, Table))])
