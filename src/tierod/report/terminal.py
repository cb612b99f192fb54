"""The verdict in the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tierod.core.findings import Diagnosis, Finding
from tierod.core.shown import shown
from tierod.report.deciding import deciding
from tierod.report.display import evidence, instant, interval, number, words
from tierod.report.elements import COLUMNS, rows
from tierod.report.status import appearance, overall

if TYPE_CHECKING:
    from rich.console import Console


def show(diagnosis: Diagnosis, console: Console) -> None:
    """Print all findings, the decisive one first, and the remarks on the data."""
    from rich.markup import escape

    if not diagnosis.findings:
        console.print(
            f"[{appearance(overall(diagnosis)).style}]{overall(diagnosis)}[/]: no monitor ran on this recording"
        )
    for finding in diagnosis.findings:
        _finding(diagnosis, finding, console)
    if diagnosis.elements:
        _elements(diagnosis, console)
    told = {warning for finding in diagnosis.findings for warning in finding.warnings}
    remarks = [(row.name, remark) for row in diagnosis.quality for remark in row.remarks]
    remarks = [(name, remark) for name, remark in remarks if f"{name}: {remark}" not in told]
    if remarks:
        console.print("\n[bold]Remarks on the data[/bold]")
        for name, remark in remarks:
            console.print(f"  {escape(words(name))}: {escape(remark)}")


def _elements(diagnosis: Diagnosis, console: Console) -> None:
    """The table of sensors and actuators; columns that nobody fills are left out."""
    from rich.markup import escape
    from rich.table import Table

    lines = [row for element in diagnosis.elements for row in rows(element)]
    filled = [place for place, _ in enumerate(COLUMNS) if any(row.cells[place] for row in lines)]
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), title_justify="left")
    for place in filled:
        table.add_column(COLUMNS[place], overflow="fold", header_style="dim")
    for row in lines:
        cells = [escape(row.cells[place]) for place in filled]
        table.add_row(cells[0], f"[{row.looks.style}]{cells[1]}[/]" if cells[1] else "", *cells[2:])
    console.print("\n[bold]Sensors and actuators[/bold]")
    console.print(table)


def _finding(diagnosis: Diagnosis, finding: Finding, console: Console) -> None:
    from rich.markup import escape
    from rich.table import Table

    looks = appearance(finding.status)
    console.print(f"[{looks.style}]{looks.symbol} {finding.status.upper()}[/]  {escape(finding.headline)}")
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    for name, text in _rows(diagnosis, finding):
        table.add_row(escape(name), escape(text))
    console.print(table)


def _rows(diagnosis: Diagnosis, finding: Finding) -> list[tuple[str, str]]:
    rows = [("monitor", finding.monitor)]
    if finding.since is not None:
        rows.append(("change began", instant(finding.since) if finding.since > 0.0 else "at the start"))
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
