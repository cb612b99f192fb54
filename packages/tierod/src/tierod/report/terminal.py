"""Terminal output of the items of a report, and of a fault memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from tierod.core.content import Facts, Flag, Heading, Item, Table, Verdict
from tierod.core.shown import counted, shown
from tierod.core.signals import SIGNALS
from tierod.core.statuses import Status
from tierod.report.display import dated, interval, number, words

if TYPE_CHECKING:
    import rich.table
    from rich.console import Console

    from tierod.core.findings import Finding
    from tierod.diagnosis.entry import FreezeFrame
    from tierod.diagnosis.fault_memory import FaultMemory
    from tierod.report.charts.figure import Figure


LINES = 3  # lines of a reason in the answer
NAMES = 12  # columns that the names of reasons take


def show(items: Iterable[Item | Figure], console: Console) -> None:
    """Print verdicts, headings, tables and facts; charts and folds are left to the page."""
    from rich.text import Text

    for item in items:
        match item:
            case Verdict():
                _verdict(item, console)
            case Heading():
                console.print(Text(f"\n{item.title}", style="bold"))
                for paragraph in item.text:
                    console.print(Text(paragraph))
            case Table():
                if item.title:
                    console.print(Text(f"\n{item.title}", style="bold"))
                console.print(rows(item.header, item.rows, item.numeric))
                if item.note:
                    console.print(Text(item.note))
            case Facts():
                _facts(item.rows, console)


def answer(finding: Finding, remarks: int, console: Console, missed: int = 0) -> None:
    """Print status, headline, why and what to do, each in at most three lines; `--details` prints all.

    Args:
        remarks, missed: number of remarks and of monitors that did not run, which are left to the details
    """
    from rich.text import Text

    console.print(Text.assemble((finding.status.capitals, finding.status.style), f"  {finding.headline}"))
    action = "" if finding.action == "none" else finding.action
    when = "" if "since" in finding.headline else dated(finding)
    reasons = [
        (name, text) for name, text in (("change", when), ("why", finding.cause), ("what to do", action)) if text
    ]
    _facts([(name, _short(text, console.width)) for name, text in reasons], console)
    more = ["figures and limits"]
    more += [counted(remarks, "remark")] if remarks else []
    more += [f"{counted(missed, 'monitor')} that did not run"] if missed else []
    console.print(Text(f"more with --details: {', '.join(more)}", style="dim"))


def _short(text: str, width: int) -> str:
    """The first clauses of a text that fit into three lines."""
    most = LINES * (width - NAMES)
    if len(text) <= most:
        return text
    kept = text[: most - 2].rpartition("; ")[0] or text[: most - 2].rpartition(" ")[0]
    return f"{kept} ..."


def rows(titles: Sequence[str], cells: Iterable[Sequence[str]], right: Sequence[int] = ()) -> rich.table.Table:
    """A plain table; square brackets are text, and a status or mark gets its looks."""
    from rich.table import Table as Rich
    from rich.text import Text

    def text(cell: str) -> Text:
        return Text(cell.capitals, style=cell.style) if isinstance(cell, Status | Flag) else Text(cell)

    table = Rich(box=None, pad_edge=False, header_style="bold")
    for index, title in enumerate(titles):
        table.add_column(Text(title), justify="right" if index in right else "left", overflow="fold")
    for row in cells:
        table.add_row(*map(text, row))
    return table


def _verdict(verdict: Verdict, console: Console) -> None:
    from rich.text import Text

    status = verdict.status
    if status is None:
        console.print(Text(verdict.headline, style="bold"))
    else:
        console.print(Text.assemble((status.capitals, status.style), f"  {verdict.headline}"))
    for paragraph in verdict.text:
        console.print(Text(paragraph))
    if status is None:
        for name, text in verdict.reasons:
            console.print(Text(f"{name}: {text}"))
    else:
        reasons = [(name.lower(), text) for name, text in (*verdict.reasons, *verdict.evidence)]
        _facts([*verdict.about, *_estimate(verdict), *reasons], console)


def _estimate(verdict: Verdict) -> Iterator[tuple[str, str]]:
    if (estimate := verdict.estimate) is not None:
        value, low, high, unit = interval(estimate)
        yield estimate.quantity, f"{value} {unit}  (95 %: {low} to {high})"
        factor, _ = shown(estimate.unit)
        levels = ", ".join(f"{words(n).lower()} {number(v * factor, 3)}" for n, v in estimate.reference.items())
        if levels:
            yield "judged against", f"{levels} {unit}"


def _facts(pairs: Iterable[tuple[str, str]], console: Console) -> None:
    from rich.table import Table as Rich
    from rich.text import Text

    table = Rich(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    for name, text in pairs:
        table.add_row(Text(name), Text(text))
    console.print(table)


def memory_items(memory: FaultMemory) -> Iterator[Item]:
    """Trouble codes of a memory, its warning lamp and its reaction."""
    cycles = "1 operation cycle" if memory.cycles == 1 else f"{memory.cycles} operation cycles"
    stored = {name: entry for name, entry in memory.entries.items() if entry.stored}
    head = f"Fault memory of {memory.vehicle or 'no vehicle'}, {cycles}, the last of {memory.date or 'never'}"
    yield Verdict(head, text=() if stored else ("No trouble codes.",))
    if not stored:
        return
    cells = []
    for name, entry in stored.items():
        code = memory.codes.codes[name]
        dates = [frame.date[:19].replace("T", " ") if frame else "" for frame in (entry.first, entry.last)]
        state = (", ".join(entry.status.words), f"{int(entry.status):02X}", str(entry.occurrences))
        cells.append((code.code, code.meaning, *state, *dates))
    lamp = f"Warning lamp {'on' if memory.lamp else 'off'}; reaction: {memory.reaction}."
    full = " The memory was full once: less important codes were displaced." if memory.overflowed else ""
    header = ("code", "meaning", "status", "byte", "occurrences", "first", "last")
    yield Table("", header, tuple(cells), lamp + full)


def snapshot_items(frame: FreezeFrame, which: str) -> Iterator[Item]:
    """Signals at the instant of a failure, with their range around it."""
    cells = []
    for name, value in frame.at_instant().items():
        around = [each for each in frame.values[name] if each is not None]
        values = (value, min(around, default=None), max(around, default=None))
        factor, unit = shown(SIGNALS[name].unit)
        cells.append((name, *("missing" if each is None else f"{number(each * factor)} {unit}" for each in values)))
    title = f"{which}: {frame.instant:.2f} s into operation cycle {frame.cycle}, begun {frame.date}"
    yield Table(title, ("signal", "at the instant", "lowest around", "highest around"), tuple(cells))
