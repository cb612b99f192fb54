"""`tierod fleet report RESULTS`: page and document of a fleet, and its first lines to the terminal."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from tierod.fleet.places import LOCAL, protocol_of
from tierod.fleet.ranking import WORDS

if TYPE_CHECKING:
    from tierod.fleet.report import FleetReport

SHOWN = 20
"""Cars that the terminal shows."""


def report(results: str, output: Path | None, as_json: bool, command: str) -> int:
    """Write fleet.html and fleet.json: no car to look at (0), some (1), nothing could be judged (2).

    Args:
        results: folder that `tierod fleet --output` named, or its address
        output: folder that takes both; that of the results where not given, the current one for an address
        as_json: print the document and nothing else
        command: what the user typed

    Raises:
        InputError: it is no results folder, or damaged
        OutputError: they cannot be written
    """
    from tierod.fleet.report import report as worked_out
    from tierod.fleet.report_document import text
    from tierod.fleet.report_page import write

    folder = output or (Path(results) if protocol_of(results) == LOCAL else Path())
    found = worked_out(results, command=command)
    page, _ = write(found, folder)
    if as_json:
        sys.stdout.write(text(found))
    else:
        _show(found)
    print(f"report: {page}", file=sys.stderr if as_json else sys.stdout)
    return 1 if found.cars else 0 if found.vehicles else 2


def _show(found: FleetReport) -> None:
    """The worst cars as a table."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from tierod.fleet import report_words as words

    console = Console(soft_wrap=True)
    counts = Counter(WORDS[car.urgency] for car in found.cars)
    console.print(words.headline(len(found.cars), found.vehicles, dict(counts)), markup=False)
    for remark in found.remarks:
        console.print(f"to know: {remark}", markup=False)
    for each in found.trends:
        for cohort in each.cohorts.differing:
            name = f"{cohort.kind} {cohort.name} ({cohort.cars} cars)"
            effect = f"{cohort.effect:+.2g} {each.series.watched.unit}"
            console.print(f"{name} differs by {effect}, odds {words.odds(cohort.log_odds)}", markup=False)
    if found.cars:
        table = Table("vehicle", "state", "level now", "time left", "why", box=None)
        for car in found.cars[:SHOWN]:
            level, left, _ = words.followed(words.first_trend(car))
            cells = (car.vehicle, WORDS[car.urgency], level, left, car.reasons[0].text)
            table.add_row(*(escape(printable(cell)) for cell in cells))
        console.print(table)


def printable(text: str) -> str:
    """A text without characters that move a terminal's cursor."""
    return "".join(each if each.isprintable() else "?" for each in text)
