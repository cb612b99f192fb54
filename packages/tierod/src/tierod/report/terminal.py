"""Terminal output of a diagnosis and of a fault memory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tierod.core.findings import Diagnosis, Finding
from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.diagnosis.entry import FreezeFrame
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.report.display import evidence, interval, number, words
from tierod.report.verdict import (
    COLUMNS,
    EFFECT_COLUMNS,
    EFFECT_HEADING,
    dated,
    deciding,
    effect_rows,
    measure_first,
    rows,
)

if TYPE_CHECKING:
    from rich.console import Console


def show(diagnosis: Diagnosis, console: Console) -> None:
    """Print all findings, the decisive one first, and remarks on the data."""
    from rich.markup import escape

    if not diagnosis.findings:
        console.print(f"[{diagnosis.status.style}]{diagnosis.status.capitals}[/]  no monitor ran on this recording")
    for finding in diagnosis.findings:
        _finding(diagnosis, finding, console)
    if diagnosis.elements:
        _elements(diagnosis, console)
    if diagnosis.parameter_effects:
        _effects(diagnosis, console)
    if note := diagnosis.remarks.get("parameters"):
        console.print(f"\n[bold]Parameters[/bold]\n  {escape(note)}")
    warned = {warning for finding in diagnosis.findings for warning in finding.warnings}
    remarks = [(row.name, remark) for row in diagnosis.quality for remark in row.remarks]
    remarks = [(name, remark) for name, remark in remarks if f"{name}: {remark}" not in warned]
    if remarks:
        console.print("\n[bold]Remarks on the data[/bold]")
        for name, remark in remarks:
            console.print(f"  {escape(words(name))}: {escape(remark)}")


def _elements(diagnosis: Diagnosis, console: Console) -> None:
    """Print the table of sensors and actuators without empty columns."""
    from rich.markup import escape
    from rich.table import Table

    lines = [row for element in diagnosis.elements for row in rows(element)]
    filled = [place for place, _ in enumerate(COLUMNS) if any(row.cells[place] for row in lines)]
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), title_justify="left")
    for place in filled:
        table.add_column(COLUMNS[place], overflow="fold", header_style="dim")
    for row in lines:
        cells = [escape(row.cells[place]) for place in filled]
        table.add_row(cells[0], f"[{row.status.style}]{cells[1]}[/]" if cells[1] else "", *cells[2:])
    console.print("\n[bold]Sensors and actuators[/bold]")
    console.print(table)


def _effects(diagnosis: Diagnosis, console: Console) -> None:
    """Print the table of uncertain parameters, ordered by their effect on the result."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for column in EFFECT_COLUMNS:
        table.add_column(column, overflow="fold", header_style="dim")
    for row in effect_rows(diagnosis):
        table.add_row(*map(escape, row))
    console.print(f"\n[bold]{EFFECT_HEADING}[/bold]")
    console.print(table)
    console.print(measure_first(diagnosis))


def _finding(diagnosis: Diagnosis, finding: Finding, console: Console) -> None:
    from rich.markup import escape
    from rich.table import Table

    status = finding.status
    console.print(f"[{status.style}]{status.capitals}[/]  {escape(finding.headline)}")
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    for name, text in _rows(diagnosis, finding):
        table.add_row(escape(name), escape(text))
    console.print(table)


def _rows(diagnosis: Diagnosis, finding: Finding) -> list[tuple[str, str]]:
    rows = [("monitor", finding.monitor), *(("in detail", each) for each in finding.details)]
    if finding.since is not None:
        rows.append(("change began", dated(finding)))
    if finding.estimate is not None:
        value, low, high, unit = interval(finding.estimate)
        factor, _ = shown(finding.estimate.unit)
        rows.append((finding.estimate.quantity, f"{value} {unit}  (95 %: {low} to {high})"))
        levels = ", ".join(f"{words(n).lower()} {number(v * factor, 3)}" for n, v in finding.estimate.reference.items())
        rows += [("judged against", f"{levels} {unit}")] if levels else []
    rows += [("decided by", sentence) for sentence in deciding(diagnosis, finding)]
    rows += [(title, text) for title, text in (("why", finding.cause), ("what to do", finding.action)) if text]
    rows += [("to know", warning) for warning in finding.warnings]
    return rows + [(name.lower(), text) for name, text in (evidence(*each) for each in finding.evidence.items())]


def print_memory(memory: FaultMemory, console: Console) -> None:
    """Print the trouble codes of a memory, its warning lamp and its reaction."""
    from rich.table import Table
    from rich.text import Text

    cycles = "1 operation cycle" if memory.cycles == 1 else f"{memory.cycles} operation cycles"
    of = f"Fault memory of {memory.vehicle or 'no vehicle'}, {cycles}, the last of {memory.date or 'never'}"
    console.print(Text(of))
    stored = {name: entry for name, entry in memory.entries.items() if entry.stored}
    if not stored:
        console.print("No trouble codes.")
        return
    table = Table("code", "meaning", "status", "byte", "occurrences", "first", "last")
    for name, entry in stored.items():
        code = memory.codes.codes[name]
        dates = [frame.date[:19].replace("T", " ") if frame else "" for frame in (entry.first, entry.last)]
        words = ", ".join(entry.status.words)
        cells = (code.code, code.meaning, words, f"{int(entry.status):02X}", str(entry.occurrences), *dates)
        table.add_row(*map(Text, cells))
    console.print(table)
    console.print(f"Warning lamp {'on' if memory.lamp else 'off'}; reaction: {memory.reaction}.")
    if memory.overflowed:
        console.print("The memory was full once: less important codes were displaced.")


def print_snapshot(frame: FreezeFrame, which: str, console: Console) -> None:
    """Print the signals at the instant of a failure, with their range around it."""
    from rich.table import Table
    from rich.text import Text

    console.print(Text(f"{which}: {frame.instant:.2f} s into operation cycle {frame.cycle}, begun {frame.date}"))
    table = Table("signal", "at the instant", "lowest around", "highest around")
    for name, value in frame.at_instant().items():
        around = [each for each in frame.values[name] if each is not None]
        values = (value, min(around, default=None), max(around, default=None))
        factor, unit = shown(SIGNALS[name].unit)
        table.add_row(name, *("missing" if each is None else f"{number(each * factor)} {unit}" for each in values))
    console.print(table)
