"""`tierod fleet report RESULTS`: page and document of a fleet, and its first lines to the terminal."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tierod.core.errors import InputError, ParameterError
from tierod.core.screen import printable
from tierod.fleet.cohorts import NOMINAL, expected_of, write_prior
from tierod.fleet.places import LOCAL, protocol_of
from tierod.fleet.ranking import WORDS

if TYPE_CHECKING:
    from tierod.fleet.report import FleetReport

SHOWN = 20
"""Cars that the terminal shows."""


def report(
    results: str,
    output: Path | None,
    as_json: bool,
    command: str,
    prior: Path | None = None,
    cohort: Sequence[str] = (),
) -> int:
    """Write fleet.html and fleet.json: no car to look at (0), some (1), nothing could be judged (2).

    Args:
        results: folder that `tierod fleet --output` named, or its address
        output: folder that takes both; that of the results where not given, the current one for an address
        as_json: print the document and nothing else
        command: what the user typed
        prior: vehicle file that takes the level which a new car may expect; None for none
        cohort: of the new car, as KIND=NAME

    Raises:
        InputError: it is no results folder, or damaged
        OutputError: they cannot be written
        ParameterError: a cohort that the fleet does not have, or a file that is no vehicle file
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
    others = sys.stderr if as_json else sys.stdout
    if prior is not None:
        print(printable(_written_prior(found, prior, cohort)), file=others)
    print(printable(f"report: {page}"), file=others)
    return 1 if found.cars else 0 if found.judged else 2


def _written_prior(found: FleetReport, path: Path, cohort: Sequence[str]) -> str:
    """Put the level that a new car may expect into a vehicle file; a sentence."""
    labels = {}
    for each in cohort:
        kind, equals, name = each.partition("=")
        if not (kind and equals and name):
            raise ParameterError(f"--cohort is '{each}'; expected KIND=NAME, such as 'rack batch=2025-47'")
        labels[kind.strip()] = name.strip()
    followed = next((each for each in found.trends if each.series.watched.quantity in NOMINAL), None)
    if followed is None or followed.cohorts.cohorts is None:
        why = "no quantity with a nominal value is followed" if followed is None else followed.cohorts.remark
        raise InputError(f"these results give no level that a new car may expect: {why}")
    expected = expected_of(followed.cohorts.cohorts, followed.series, labels)
    write_prior(path, followed.series, expected)
    size = f"{expected.value:.4g} ± {expected.standard_deviation:.2g} {followed.series.watched.unit}"
    return f"{path}: {NOMINAL[followed.series.watched.quantity]} is {size} ({expected.source})"


def _show(found: FleetReport) -> None:
    """The worst cars as a table."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from tierod.fleet import report_words as words

    console = Console(soft_wrap=True)
    counts = Counter(WORDS[car.urgency] for car in found.cars)
    console.print(words.headline(len(found.cars), found.vehicles, found.judged, dict(counts)), markup=False)
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
