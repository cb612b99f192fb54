"""A campaign in the terminal: gates, figures by group, what failed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tierod.report.campaign.words import count, false_alarms, found, place, seconds, spread, value
from tierod.report.display import number

if TYPE_CHECKING:
    from rich.console import Console

_GATES = {True: ("✓", "met", "green"), False: ("✕", "MISSED", "bold red"), None: ("?", "not judged", "yellow")}
_COLUMNS = ("", "drives", "found", "median", "95 %", "worst", "false alarms", "at most", "bias ± deviation")
_MOST = 10
"""Failed drives that are told one by one."""


def show(content: Mapping[str, Any], console: Console) -> None:
    """Print what a campaign has found."""
    from rich.table import Table
    from rich.text import Text

    for monitor in content["monitors"]:
        pools = [each for each in content["pools"] if each["monitor"] == monitor["label"]]
        table = Table(box=None, pad_edge=False, header_style="bold", title=Text(monitor["label"]), title_justify="left")
        for title in _COLUMNS:
            table.add_column(title, justify="right" if title else "left", overflow="fold", min_width=len(title))
        for pool in pools:
            figures = pool["figures"]
            times = [seconds(figures[f"detection_{name}_s"]) for name in ("median", "p95", "worst")]
            cells = (place(pool["where"]), str(figures["drives"]), found(figures), *times, *false_alarms(figures))
            table.add_row(*map(Text, (*cells, spread(figures))))
        console.print(table)
    _failures(content, console)
    for gate in content["gates"]:
        symbol, told, style = _GATES[gate["met"]]
        measured = seconds(gate["measured"]) if gate["figure"].endswith("_s") else number(value(gate["measured"]))
        line = Text.assemble(
            (f"{symbol} {told}", style), f"  {gate['name']} {gate['goal']}: {measured}; {gate['note']}"
        )
        console.print(line, soft_wrap=True)


def _failures(content: Mapping[str, Any], console: Console) -> None:
    lost = [cell for cell in content["cells"] if cell["reason"] or any(each["reason"] for each in cell["verdicts"])]
    if not lost:
        return
    console.print(f"\n{count(len(lost), 'drive')} of {len(content['cells'])} failed:", style="bold")
    for cell in lost[:_MOST]:
        reason = cell["reason"] or next(each["reason"] for each in cell["verdicts"] if each["reason"])
        console.print(f"  {cell['outcome']}: {place(cell['place'])}: {reason}", markup=False, soft_wrap=True)
    if len(lost) > _MOST:
        console.print(f"  and {len(lost) - _MOST} more; the report has all of them")
    console.print()
