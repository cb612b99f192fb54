"""Report on a fleet as one object, from which the page and the JSON document are made."""

from __future__ import annotations

import datetime as dt
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tierod.core.shown import counted
from tierod.fleet.coverage import coverage
from tierod.fleet.ranking import Ranked, ranked
from tierod.fleet.schema import JUDGED
from tierod.fleet.series import series_of
from tierod.fleet.standing import Standing, standings
from tierod.fleet.trends import Design, Trends, trends

if TYPE_CHECKING:
    import pyarrow as pa

TIMES = ("since_s", "declared_s", "end_s")
"""Columns of the findings with onset, declaration and end of an episode."""

COLUMNS = (
    "vehicle", "cohort", "recording_name", "start", "mileage_m", "temperature_K", "monitor", "judged", "quantity",
    "unit", "status", "kind", "estimate", "deviation", "shared_deviation", "nominal", "limit", "cause", "action",
    "span", *TIMES,
)  # fmt: skip
"""Columns of the findings that a report needs."""


@dataclass(frozen=True)
class LedgerRow:
    """Recordings of the ledger with the same outcome and reason.

    Args:
        outcome, reason: their common outcome and reason
        count: number of recordings
        examples: names of up to three
    """

    outcome: str
    reason: str
    count: int
    examples: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class FleetReport:
    """Report on a fleet.

    Args:
        name: name of the results, for display
        findings: table of findings
        design: permitted false alarms
        trends: trends of every quantity, the one with most drives first
        cars: cars to inspect, the worst first
        recovered: elements that were faulty, rising or suspect, and healthy in all of their last judged drives
        vehicles: number of cars with findings
        judged: number of these with a verdict
        confirmed: number of these of which a monitor said healthy or consistent
        outcomes: number of recordings by outcome
        ledger: outcomes with their reasons, the most frequent first, without judged recordings
        remarks: notices for a reader
        created: time of creation, as text
        command: the command line
    """

    name: str
    findings: pa.Table
    design: Design
    trends: tuple[Trends, ...]
    cars: tuple[Ranked, ...]
    recovered: tuple[Standing, ...]
    vehicles: int
    judged: int
    confirmed: int
    outcomes: dict[str, int]
    ledger: tuple[LedgerRow, ...]
    remarks: tuple[str, ...]
    created: str
    command: str = ""


def report(results: str | Path, design: Design | None = None, command: str = "") -> FleetReport:
    """Report on the results of a fleet.

    Args:
        results: the folder that `tierod fleet -o` wrote, or its address
        design: permitted false alarms; the default if not given
        command: the command line

    Raises:
        InputError: the folder holds no results, was written by a later tierod, or a file is damaged
    """
    from tierod.fleet.results import findings_of, ledger_of

    return worked_out(findings_of(results, COLUMNS), ledger_of(results), design or Design(), str(results), command)


def worked_out(findings: pa.Table, ledger: pa.Table, design: Design, name: str = "", command: str = "") -> FleetReport:
    """Report on findings and ledger of a fleet.

    Args:
        findings, ledger: see `tierod.fleet.schema`
        design: permitted false alarms
        name: name of the results
        command: the command line
    """
    now = dt.datetime.now(dt.UTC)
    series, remarks = series_of(findings, now.timestamp() / 86400.0 + 1.0)
    found = tuple(trends(each, design) for each in series)
    standing = standings(findings)
    recovered = tuple(each for each in standing if not each.drives)
    covered, outcomes = coverage(findings), Counter(ledger["outcome"].to_pylist())
    return FleetReport(
        name,
        findings,
        design,
        found,
        tuple(ranked(found, standing)),
        recovered,
        covered.vehicles,
        covered.judged,
        covered.confirmed,
        dict(outcomes),
        tuple(_ledger(ledger)),
        (*remarks, *covered.remarks, *_recovered(recovered), *_left_out(outcomes)),
        now.isoformat(timespec="seconds"),
        command,
    )


def _recovered(standing: Sequence[Standing]) -> tuple[str, ...]:
    """Remark on cars that were not always healthy, but are now; empty if there are none."""
    if not standing:
        return ()
    more = f"; {len(standing) - 3} more are in the JSON document" if len(standing) > 3 else ""
    return (f"healthy again: {'; '.join(f'{each.vehicle}, {each.history}' for each in standing[:3])}{more}",)


def _left_out(outcomes: Counter[str]) -> tuple[str, ...]:
    """Remark on recordings that were not judged; empty if all were."""
    total, judged = outcomes.total(), outcomes[JUDGED]
    if judged == total:
        return ()
    were = "was" if total - judged == 1 else "were"
    return (f"{total - judged} of {counted(total, 'recording')} {were} not judged; the page lists the reasons",)


def _ledger(ledger: pa.Table) -> list[LedgerRow]:
    """Recordings that were not judged, grouped by outcome and reason."""
    alike: dict[tuple[str, str], list[str]] = {}
    columns: list[Sequence[str]] = [ledger[name].to_pylist() for name in ("outcome", "reason", "recording_name")]
    for outcome, reason, name in zip(*columns, strict=True):
        if outcome != JUDGED:
            # A reason that begins with the name of its recording would differ from every other one.
            bare = (reason or "").removeprefix(f"{name or ''}: ").removeprefix(f"{name or ''} ")
            alike.setdefault((outcome, bare), []).append(name)
    rows = [LedgerRow(*key, len(names), tuple(names[:3])) for key, names in alike.items()]
    return sorted(rows, key=lambda row: -row.count)
