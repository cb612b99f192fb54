"""Report on a fleet as one object, from which the page and the JSON document are made."""

from __future__ import annotations

import dataclasses
import datetime as dt
import json
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tierod.core.shown import counted
from tierod.core.statuses import Status
from tierod.core.version import __version__
from tierod.fleet import report_words as words
from tierod.fleet import schema
from tierod.fleet.ranking import WORDS, Ranked, Reason, Urgency, date, ranked
from tierod.fleet.series import series_of
from tierod.fleet.standing import JUDGED, LAST, OFTEN, Standing, standings
from tierod.fleet.standing import counted as counted_statuses
from tierod.fleet.trends import Design, Trends, trends
from tierod.methods.trends.change_evidence import STEP
from tierod.report.document import plain

if TYPE_CHECKING:
    import pyarrow as pa


class Coverage(NamedTuple):
    """Number of cars with a verdict, and gaps in the coverage."""

    vehicles: int  # number of cars with findings
    judged: int  # number of these with a verdict of at least one monitor
    confirmed: int  # number of these of which a monitor said healthy, or consistent: an estimate alone confirms nothing
    remarks: tuple[str, ...]  # monitors without a verdict on some of the cars that they examined, and why


def coverage(findings: pa.Table) -> Coverage:
    """Count cars with a verdict, and list monitors without one."""
    import pyarrow as pa
    import pyarrow.compute as pc

    verdict = pc.is_in(findings["status"], pa.array([str(each) for each in JUDGED]))
    good = pc.is_in(findings["status"], pa.array([str(each) for each in JUDGED if each.colour == "good"]))
    table = findings.select(["vehicle", "monitor", "status"]).append_column("verdict", verdict)
    table = table.append_column("good", good)
    cars = table.group_by("vehicle").aggregate([("verdict", "any"), ("good", "any")])
    pairs = table.group_by(["vehicle", "monitor"]).aggregate([("verdict", "any"), ("status", "max")]).to_pylist()
    looked = Counter(pair["monitor"] for pair in pairs)
    open_ = [(pair["monitor"], pair["status_max"]) for pair in pairs if not pair["verdict_any"]]
    remarks = tuple(
        f"{monitor}: no verdict on {count} of {looked[monitor]} cars ({_most(open_, monitor)})"
        for monitor, count in sorted(Counter(monitor for monitor, _ in open_).items())
    )
    judged, confirmed = (sum(cars[f"{name}_any"].to_pylist()) for name in ("verdict", "good"))
    return Coverage(cars.num_rows, judged, confirmed, remarks)


def _most(pairs: list[tuple[str, str]], monitor: str) -> str:
    statuses = Counter(status for name, status in pairs if name == monitor)
    return ", ".join(status for status, _ in statuses.most_common(3))


TIMES = ("since_s", "declared_s", "end_s")  # Columns of the findings with onset, declaration and end of an episode

COLUMNS = (
    "vehicle", "cohort", "recording_name", "start", "mileage_m", "temperature_K", "monitor", "judged", "quantity",
    "unit", "status", "kind", "estimate", "deviation", "shared_deviation", "nominal", "limit", "cause", "action",
    "span", *TIMES,
)  # fmt: skip
"""Columns of the findings that a report needs."""


@dataclass(frozen=True)
class LedgerRow:
    """Recordings of the ledger with the same outcome and reason."""

    outcome: str
    reason: str
    count: int
    examples: tuple[str, ...]  # names of up to three


@dataclass(frozen=True, eq=False)
class FleetReport:
    """Report on a fleet."""

    name: str  # name of the results, for display
    findings: pa.Table
    design: Design  # permitted false alarms
    trends: tuple[Trends, ...]  # trends of every quantity, the one with most drives first
    cars: tuple[Ranked, ...]  # cars to inspect, the worst first
    # elements that were faulty, rising or suspect, and healthy in all of their last judged drives
    recovered: tuple[Standing, ...]
    vehicles: int  # number of cars with findings
    judged: int  # number of these with a verdict
    confirmed: int  # number of these of which a monitor said healthy or consistent
    outcomes: dict[str, int]  # number of recordings by outcome
    ledger: tuple[LedgerRow, ...]  # outcomes with their reasons, the most frequent first, without judged recordings
    remarks: tuple[str, ...]
    created: str  # time of creation, as text
    command: str = ""

    @property
    def title(self) -> str:
        """First line: the worst true statement."""
        vehicles, judged, cars = self.vehicles, self.judged, self.cars
        if not vehicles:
            return "There are no findings yet"
        if cars:
            counts = Counter(car.urgency for car in cars)
            drives = counted_statuses(status for car in cars for status in car.to_confirm)
            parts = [
                f"{count} {WORDS[urgency]}" + (f" ({drives})" if urgency is Urgency.CONFIRM and drives else "")
                for urgency, count in sorted(counts.items())
            ]
            return f"{len(cars)} of {vehicles} car{'s' * (vehicles > 1)} to look at: {', '.join(parts)}"
        if not judged:
            return f"No verdict on any of {vehicles} car{'s' * (vehicles > 1)}"
        if judged < vehicles:
            return f"No car of the {judged} with a verdict needs a look; {vehicles - judged} gave none"
        return f"No car of {vehicles} needs a look"

    @property
    def state(self) -> tuple[str, str, str]:
        """Symbol, appearance and word of the worst state."""
        if self.cars:
            return (*words.LOOKS[self.cars[0].urgency], self.cars[0].state)
        if self.vehicles > self.judged:
            missing = self.vehicles - self.judged
            return "?", "open", "no verdict" if not self.judged else f"no verdict on {missing} of {self.vehicles} cars"
        if self.judged > self.confirmed:
            return Status.ESTIMATED.symbol, Status.ESTIMATED.colour, Status.ESTIMATED
        return ("✓", "good", "nothing found") if self.judged else ("?", "open", "no findings")

    @property
    def advice(self) -> tuple[str, ...]:
        """Paragraphs on what the reader should do."""
        if not self.vehicles:
            return ("What to do: judge recordings with 'tierod fleet RECORDINGS -o RESULTS'; write this page anew.",)
        urgencies = {car.urgency for car in self.cars}
        confirm = (
            "look at the named drives of the cars to confirm with 'tierod diagnose', and judge their next drives. "
            f"{OFTEN} faults in the last {LAST} judged drives are a persistent fault; {LAST} healthy ones clear a car."
        )
        if urgencies - {Urgency.CONFIRM}:
            first = "What to do: call in the cars of the first table from its top; each row names the part to inspect."
            return (first, *([f"L{confirm[1:]}"] if Urgency.CONFIRM in urgencies else []))
        if urgencies:
            return (f"What to do: {confirm}",)
        if self.judged < self.vehicles:
            return (
                "What to do: find out why cars gave no verdict: run 'tierod diagnose' on one of their recordings; its "
                "report shows what the drive, the recording or the vehicle file lacks.",
            )
        return ("What to do: nothing. Judge the next drives with 'tierod fleet', and write this page anew.",)


def report(results: str | Path, design: Design | None = None, command: str = "") -> FleetReport:
    from tierod.fleet.results import findings_of, ledger_of

    return worked_out(findings_of(results, COLUMNS), ledger_of(results), design or Design(), str(results), command)


def worked_out(findings: pa.Table, ledger: pa.Table, design: Design, name: str = "", command: str = "") -> FleetReport:
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
    total, judged = outcomes.total(), outcomes[schema.JUDGED]
    if judged == total:
        return ()
    were = "was" if total - judged == 1 else "were"
    return (f"{total - judged} of {counted(total, 'recording')} {were} not judged; the page lists the reasons",)


def _ledger(ledger: pa.Table) -> list[LedgerRow]:
    """Recordings that were not judged, grouped by outcome and reason."""
    alike: dict[tuple[str, str], list[str]] = {}
    columns: list[Sequence[str]] = [ledger[name].to_pylist() for name in ("outcome", "reason", "recording_name")]
    for outcome, reason, name in zip(*columns, strict=True):
        if outcome != schema.JUDGED:
            # A reason that begins with the name of its recording would differ from every other one.
            bare = (reason or "").removeprefix(f"{name or ''}: ").removeprefix(f"{name or ''} ")
            alike.setdefault((outcome, bare), []).append(name)
    rows = [LedgerRow(*key, len(names), tuple(names[:3])) for key, names in alike.items()]
    return sorted(rows, key=lambda row: -row.count)


SCHEMA = "tierod.fleet/2"  # Name and version of the JSON document


def text(report: FleetReport) -> str:
    """The document as text; values that JSON cannot represent (NaN, infinity) become null."""
    return json.dumps(plain(document(report)), ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def document(report: FleetReport) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "version": __version__,
        "created": report.created,
        "command": report.command,
        "results": report.name,
        "design": dataclasses.asdict(report.design),
        **dict(zip(("symbol", "colour", "status"), report.state, strict=True)),
        "title": report.title,
        "vehicles": report.vehicles,
        "vehicles_with_verdict": report.judged,
        "recordings": report.outcomes,
        "not_judged": [dataclasses.asdict(row) for row in report.ledger],
        "remarks": list(report.remarks),
        "quantities": [_quantity(each) for each in report.trends],
        "cars": [_car(report, place, car) for place, car in enumerate(report.cars)],
        "recovered": [_recovered_document(report, each) for each in report.recovered],
    }


def _quantity(trends: Trends) -> dict[str, Any]:
    series, known = trends.series, trends.learnt
    found = trends.cohorts.cohorts
    return {
        **series.watched._asdict(),
        "vehicles": len(series.vehicles),
        "drives": int(series.drives.present.sum()),
        "drive_scatter": known.scatter.scatter,
        "deviation_scale": known.scatter.scale,
        "wrong_share": known.scatter.wrong_share,
        "per_kelvin": float(known.scatter.effects[0]),
        "per_10000_km": float(known.prior.mean[..., 3].mean()),
        "level_walk": known.wander.level_walk,
        "remarks": list(known.remarks),
        "mean": None if found is None else found.mean,
        "between_cars": None if found is None else found.between,
        "cohorts": [] if found is None else [{**dataclasses.asdict(each), "alike": [list(pair) for pair in each.alike]}
                                            for each in found.all],
        "steps": {
            name: step(trends, car) for car, name in enumerate(series.vehicles) if math.isfinite(trends.stepped(car))
        },
        "levels": {
            vehicle: list(trends.stated(number)) for number, vehicle in enumerate(series.vehicles)
        },
    }  # fmt: skip


def _car(report: FleetReport, place: int, car: Ranked) -> dict[str, Any]:
    return {
        "rank": place + 1,
        "vehicle": car.vehicle,
        "state": WORDS[car.urgency],
        "summary": car.state,
        "reasons": [_reason(report, reason) for reason in car.reasons],
    }


def _recovered_document(report: FleetReport, standing: Standing) -> dict[str, Any]:
    return {
        "vehicle": standing.vehicle,
        "monitor": standing.monitor,
        "judged": standing.judged,
        "text": standing.history,
        "drives": _drives(report, [each.row for each in standing.earlier]),
    }


def _drives(report: FleetReport, rows: Sequence[int]) -> list[dict[str, Any]]:
    drives = report.findings.select(["recording_name", "start", "status", *TIMES, "estimate", "deviation"])
    return [
        {
            **row,
            **Status(row["status"] or Status.NOT_AVAILABLE).document(),
            "start": None if row["start"] is None else row["start"].isoformat(),
        }
        for row in drives.take(list(rows)).to_pylist()
    ]


def _reason(report: FleetReport, reason: Reason) -> dict[str, Any]:
    return {
        "state": WORDS[reason.urgency],
        "text": reason.text,
        "inspect": reason.inspect,
        "trend": None if reason.trends is None else _trend(*reason.trends),
        "drives": _drives(report, reason.rows),
    }


def _trend(trends: Trends, car: int) -> dict[str, Any]:
    series = trends.series
    changed = trends.changed(car)
    return {
        **series.watched._asdict(),
        "level": trends.stated(car),
        "step": step(trends, car),
        "unconfirmed": trends.unconfirmed[car],
        "slope_per_day": trends.slope[car],
        "nominal": series.nominal[car],
        "limit": series.limit[car],
        "chance_of_limit_in_90_days": trends.chance[car],
        "days_to_limit": trends.left[car],
        "log_evidence": trends.logarithm[car],
        "listed": bool(trends.listed[car]),
        "alarmed": _day(trends.alarmed[car]),
        "change": None if not changed else {
            "kind": "step" if trends.kind[car] == STEP else "ramp",
            "size": trends.size[car],
            "began": _day(trends.began[car]),
            "earliest": _day(trends.earliest[car]),
            "latest": _day(trends.latest[car]),
        },
        "cohort": {kind: names[car] for kind, names in series.labels.items()},
    }  # fmt: skip


def step(trends: Trends, car: int) -> dict[str, Any] | None:
    since = _day(trends.stepped(car))
    return None if since is None else {"since": since, "before": float(trends.before[car])}


def _day(value: float) -> str | None:
    return date(float(value)) if math.isfinite(value) else None
