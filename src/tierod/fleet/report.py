"""Report on a fleet, as one object; page and JSON are made from it alone."""

from __future__ import annotations

import datetime as dt
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tierod.fleet.coverage import coverage
from tierod.fleet.ranking import Ranked, ranked
from tierod.fleet.schema import JUDGED
from tierod.fleet.series import series_of
from tierod.fleet.standing import standings
from tierod.fleet.trends import Design, Trends, trends

if TYPE_CHECKING:
    import pyarrow as pa

COLUMNS = (
    "vehicle", "cohort", "recording_name", "start", "mileage_m", "temperature_K", "monitor", "judged", "quantity",
    "unit", "status", "word", "kind", "estimate", "deviation", "nominal", "limit", "cause", "action", "span",
)  # fmt: skip
"""Of the findings, that a report reads."""


@dataclass(frozen=True)
class LedgerRow:
    """Row of the ledger: an outcome and its recordings.

    Args:
        outcome, reason: the same for all of them
        count: how many
        examples: names of some
    """

    outcome: str
    reason: str
    count: int
    examples: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class FleetReport:
    """Report on a fleet.

    Args:
        name: of the results, for people
        findings: table that it rests on
        design: how often it may be wrong
        trends: of every quantity, that of most drives first
        cars: to be looked at, worst first
        vehicles: how many there are
        judged: of them, with a verdict
        outcomes: of recordings: outcome -> how many
        ledger: outcomes with their reasons, the most frequent first; judged ones without remark are not among them
        remarks: notices for a reader
        created: when, as text
        command: what the user typed
    """

    name: str
    findings: pa.Table
    design: Design
    trends: tuple[Trends, ...]
    cars: tuple[Ranked, ...]
    vehicles: int
    judged: int
    outcomes: dict[str, int]
    ledger: tuple[LedgerRow, ...]
    remarks: tuple[str, ...]
    created: str
    command: str = ""


def report(results: str | Path, design: Design | None = None, command: str = "") -> FleetReport:
    """Report on the results of a fleet.

    Args:
        results: the folder that `tierod fleet -o` wrote, or its address
        design: how often it may be wrong; the usual one where not given
        command: what the user typed

    Raises:
        InputError: it is no results folder, was written by a later tierod, or a file is damaged
    """
    from tierod.fleet.results import findings_of, ledger_of

    return worked_out(findings_of(results, COLUMNS), ledger_of(results), design or Design(), str(results), command)


def worked_out(findings: pa.Table, ledger: pa.Table, design: Design, name: str = "", command: str = "") -> FleetReport:
    """Report on findings and ledger of a fleet.

    Args:
        findings, ledger: see `tierod.fleet.schema`
        design: how often it may be wrong
        name: of the results
        command: what the user typed
    """
    now = dt.datetime.now(dt.UTC)
    series, remarks = series_of(findings, now.timestamp() / 86400.0 + 1.0)
    found = tuple(trends(each, design) for each in series)
    covered, outcomes = coverage(findings), Counter(ledger["outcome"].to_pylist())
    return FleetReport(
        name,
        findings,
        design,
        found,
        tuple(ranked(found, standings(findings))),
        covered.vehicles,
        covered.judged,
        dict(outcomes),
        tuple(_ledger(ledger)),
        (*remarks, *covered.remarks, *_left_out(outcomes)),
        now.isoformat(timespec="seconds"),
        command,
    )


def _left_out(outcomes: Counter[str]) -> tuple[str, ...]:
    """A remark on recordings that were not judged; none where all were."""
    total, judged = outcomes.total(), outcomes[JUDGED]
    if judged == total:
        return ()
    return (f"{total - judged} of {total} recordings were not judged; the page lists the reasons",)


def _ledger(ledger: pa.Table) -> list[LedgerRow]:
    """Alike rows together."""
    alike: dict[tuple[str, str], list[str]] = {}
    columns: list[Sequence[str]] = [ledger[name].to_pylist() for name in ("outcome", "reason", "recording_name")]
    for outcome, reason, name in zip(*columns, strict=True):
        if outcome != JUDGED:
            # A reason that begins with the name of its recording would be alike to no other one.
            bare = (reason or "").removeprefix(f"{name or ''}: ").removeprefix(f"{name or ''} ")
            alike.setdefault((outcome, bare), []).append(name)
    rows = [LedgerRow(*key, len(names), tuple(names[:3])) for key, names in alike.items()]
    return sorted(rows, key=lambda row: -row.count)
