"""The JSON document of a fleet report, whose schema is installed beside this module."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Sequence
from typing import Any

from tierod.core.statuses import Status
from tierod.core.version import __version__
from tierod.fleet import report_words as words
from tierod.fleet.ranking import WORDS, Ranked, Reason, date
from tierod.fleet.report import TIMES, FleetReport
from tierod.fleet.standing import Standing
from tierod.fleet.trends import Trends
from tierod.methods.trends.change_evidence import STEP
from tierod.report.document import plain

SCHEMA = "tierod.fleet/2"
"""Name and version of the JSON document."""


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
        **dict(zip(("symbol", "colour", "status"), words.verdict(report), strict=True)),
        "title": words.headline(report),
        "vehicles": report.vehicles,
        "vehicles_with_verdict": report.judged,
        "recordings": report.outcomes,
        "not_judged": [dataclasses.asdict(row) for row in report.ledger],
        "remarks": list(report.remarks),
        "quantities": [_quantity(each) for each in report.trends],
        "cars": [_car(report, place, car) for place, car in enumerate(report.cars)],
        "recovered": [_recovered(report, each) for each in report.recovered],
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


def _recovered(report: FleetReport, standing: Standing) -> dict[str, Any]:
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
