"""Implementation of `tierod fleet report RESULTS`: page and document of a fleet, and a summary in the terminal."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tierod.core.errors import InputError, ParameterError
from tierod.core.screen import printable
from tierod.core.shown import plus_minus
from tierod.core.statuses import COLOURS
from tierod.fleet.places import LOCAL, protocol_of
from tierod.fleet.statistics import NOMINAL, expected_of, write_prior

if TYPE_CHECKING:
    from tierod.fleet.report import FleetReport

SHOWN = 20
"""Number of cars shown in the terminal."""

PIPED_WIDTH = 160
"""Width of the table in columns if the output is no terminal."""


def report(
    results: str,
    output: Path | None,
    as_json: bool,
    command: str,
    prior: Path | None = None,
    cohort: Sequence[str] = (),
) -> int:
    """Write fleet.html and fleet.json, and return an exit code: no car to inspect (0), some (1), no verdict (2)."""
    from tierod.fleet.report import report as worked_out
    from tierod.fleet.report import text
    from tierod.fleet.report_page import write

    folder = output or (Path(results) if protocol_of(results) == LOCAL else Path())
    found = worked_out(results, command=command)
    page, _ = write(found, folder)
    if as_json:
        sys.stdout.write(text(found))
    else:
        _show(found)
    others = sys.stderr if as_json else sys.stdout
    if prior is not None:
        print(printable(_written_prior(found, prior, cohort)), file=others)
    print(printable(f"report: {page}"), file=others)
    return 1 if found.cars else 0 if found.judged else 2


def _written_prior(found: FleetReport, path: Path, cohort: Sequence[str]) -> str:
    """Write the level expected of a new car into a vehicle file; returns a sentence on it."""
    labels = {}
    for each in cohort:
        kind, equals, name = each.partition("=")
        if not (kind and equals and name):
            raise ParameterError(f"--cohort is '{each}'; expected KIND=NAME, such as 'rack batch=2025-47'")
        labels[kind.strip()] = name.strip()
    followed = next((each for each in found.trends if each.series.watched.quantity in NOMINAL), None)
    if followed is None or followed.cohorts.cohorts is None:
        why = "no quantity with a nominal value is followed" if followed is None else followed.cohorts.remark
        raise InputError(f"these results give no expected level of a new car: {why}")
    expected = expected_of(followed.cohorts.cohorts, followed.series, labels)
    write_prior(path, followed.series, expected)
    size = plus_minus(expected.value, expected.standard_deviation, followed.series.watched.unit)
    return f"{path}: {NOMINAL[followed.series.watched.quantity]} is {size} ({expected.source})"


def _show(found: FleetReport) -> None:
    """Print the summary, and the worst cars as a table."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table
    from rich.text import Text

    from tierod.fleet import report_words as words

    console = Console(soft_wrap=True, width=None if sys.stdout.isatty() else PIPED_WIDTH)
    symbol, colour, state = words.verdict(found)
    console.print(Text.assemble((f"{symbol} {state.upper()}", COLOURS[colour]), f"  {words.headline(found)}"))
    for remark in found.remarks:
        console.print(f"to know: {remark}", markup=False)
    for each in found.trends:
        for cohort in each.cohorts.differing:
            name = f"{cohort.kind} {cohort.name} ({cohort.cars} cars)"
            effect = plus_minus(cohort.effect, cohort.deviation, each.series.watched.unit, signed=True)
            console.print(f"{name} differs by {effect}, odds {words.odds(cohort.log_odds)}", markup=False)
    if found.cars:
        table = Table("vehicle", "state", "level now (± 1 σ)", "time left (90 %)", box=None)
        for car in found.cars[:SHOWN]:
            level, left, _ = words.followed(words.first_trend(car))
            table.add_row(*(escape(printable(cell)) for cell in (car.vehicle, car.state, level, left)))
        console.print(table)
        for car in found.cars[:SHOWN]:
            console.print(printable(f"{car.vehicle}: {car.why}"), markup=False)
