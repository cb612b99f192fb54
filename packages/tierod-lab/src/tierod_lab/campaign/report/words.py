"""Figures of a campaign as text, and its terminal output: pass criteria, figures by group, failures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tierod.core.shown import shown
from tierod.report.display import duration, number, share

if TYPE_CHECKING:
    from rich.console import Console


NEVER = "never"

TITLES = {
    "detection_s": "time to the alarm",
    "detection_enabled_s": "enabled time to the alarm",
    "bias": "bias",
    "absolute_bias": "size of the bias",
    "deviation": "deviation of the estimate",
    "value": "last estimate",
    "false_alarms": "false alarms",
    "judged_s": "time judged",
}
"""Readable names of the figures of a comparison."""


def value(given: float | str | None) -> float:
    """A number of the document: null means NaN, "inf" infinity."""
    return math.nan if given is None else float(given)


def seconds(given: float | str | None) -> str:
    """A time as text; "never" where it is infinite."""
    time = value(given)
    return NEVER if math.isinf(time) else duration(time)


def count(number_: int, one: str, many: str | None = None) -> str:
    """A number with its noun: "1 drive", "3 drives"."""
    return f"{number_} {one if number_ == 1 else many or one + 's'}"


def rate(given: float | str | None) -> str:
    """Number of events per hour, as text."""
    return number(value(given), 3)


def place(where: Mapping[str, object]) -> str:
    """A cell of the matrix as text: "car midsize, fault step 4"."""
    if not where:
        return "all drives"
    parts, fault = [], ""
    for axis, level in where.items():
        if axis in ("fault", "size"):
            fault = f"{fault} {_levels(level)}".strip()
        elif level != "":
            parts.append(f"{axis} {_levels(level)}")
    return ", ".join([*parts, *([fault] if fault else [])])


def _levels(levels: object) -> str:
    several = levels if isinstance(levels, list) else [levels]
    return " or ".join(f"{level:g}" if isinstance(level, float) else str(level) for level in several)


def spread(figures: Mapping[str, Any], ending: str = "") -> str:
    """Bias and standard deviation as text: "+0.12 ± 0.30"."""
    bias, deviation = value(figures[f"bias{ending}"]), value(figures[f"deviation{ending}"])
    if math.isnan(bias):
        return "–"
    sign = "+" if bias >= 0.0 else ""
    return f"{sign}{number(bias, 3)} ± {number(deviation, 3)}"


def found(figures: Mapping[str, Any]) -> str:
    """Number of detected faults, of those that were not preceded by an alarm."""
    could = figures["faulty"] - figures["early"]
    return f"{figures['found']} of {could}" if could else "–"


def false_alarms(figures: Mapping[str, Any]) -> tuple[str, str]:
    """(false alarms in judged hours, upper bound of their rate), as text."""
    hours = value(figures["fault_free_judged_hours"])
    if not hours > 0.0:
        return "–", "–"
    return f"{figures['false_alarms']} in {number(hours, 3)} h", f"{rate(figures['false_alarm_bound'])}/h"


def shared(figures: Mapping[str, Any], name: str) -> str:
    """A share in per cent, as text."""
    return share(value(figures[name]))


def amount(given: float, unit: str) -> str:
    """A value with its unit, as text."""
    factor, label = shown(unit)
    return f"{number(given * factor, 3)} {label}".strip()


_GATES = {True: ("✓", "met", "green"), False: ("✕", "MISSED", "bold red"), None: ("?", "not judged", "yellow")}
_COLUMNS = ("", "drives", "found", "median", "95 %", "worst", "false alarms", "at most", "bias ± deviation")
_MOST = 10
"""Largest number of failed drives that are listed individually."""


def show(content: Mapping[str, Any], console: Console) -> None:
    """Print the results of a campaign to a terminal."""
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
        symbol, word, style = _GATES[gate["met"]]
        measured = seconds(gate["measured"]) if gate["figure"].endswith("_s") else number(value(gate["measured"]))
        line = Text.assemble(
            (f"{symbol} {word}", style), f"  {gate['name']} {gate['goal']}: {measured}; {gate['note']}"
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
