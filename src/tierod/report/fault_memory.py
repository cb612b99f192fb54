"""A fault memory in the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.diagnosis.entry import FreezeFrame
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.report.display import number

if TYPE_CHECKING:
    from rich.console import Console


def print_memory(memory: FaultMemory, console: Console) -> None:
    """The codes that a memory holds, and what they ask for."""
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
    """Signals at the instant of a failure, and how far they ran around it."""
    from rich.table import Table
    from rich.text import Text

    console.print(Text(f"{which}: {frame.instant:.2f} s into operation cycle {frame.cycle}, begun {frame.date}"))
    table = Table("signal", "at the instant", "lowest around", "highest around")
    for name, value in frame.at_instant().items():
        around = [each for each in frame.values[name] if each is not None]
        told = (value, min(around, default=None), max(around, default=None))
        factor, unit = shown(SIGNALS[name].unit)
        table.add_row(name, *("missing" if each is None else f"{number(each * factor)} {unit}" for each in told))
    console.print(table)
