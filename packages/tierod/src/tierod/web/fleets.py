"""Results of `tierod fleet` for the page: table of all cars, the worst first, cohorts, ledger, and single cars."""

from __future__ import annotations

import contextlib
import json
import os
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.files import write_text
from tierod.web.errors import Absent
from tierod.work.fingerprint import fingerprint

if TYPE_CHECKING:
    from tierod.fleet.report import FleetReport

SCHEMA = "tierod.web-fleet/2"

BANDS = 400  # Number of cars, the worst first, whose smoothed trend is stored; for others only the drives are shown


def key_of(results: Path) -> str:
    """Key of a computed fleet report: digest of the names, sizes and times of change of its files, and of the code."""
    from tierod.fleet.stamps import report_code

    found = []
    for name in ("findings", "ledger"):
        folder = results / name
        if not folder.is_dir():
            if name == "findings":
                continue
            raise Absent(f"{results.name} holds no results any more, or not yet: there is no folder '{name}' in it")
        for path in sorted(folder.rglob("*.parquet")):
            with contextlib.suppress(OSError):
                status = os.stat(path)
                found.append((str(path), status.st_size, status.st_mtime_ns))
    return fingerprint(SCHEMA, found, report_code())


def path_of(cache: Path, key: str) -> Path:
    return cache / "fleets" / f"{key}.json"


def work_out(results: Path, cache: Path, key: str) -> dict[str, Any]:
    """Compute the trends of a fleet, and store the report for the page."""
    from tierod.fleet.report import report
    from tierod.report.document import plain

    found = report(results)
    content = plain({"schema": SCHEMA, **_content(found)})
    path = path_of(cache, key)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, json.dumps(content, ensure_ascii=False, separators=(",", ":")))
    return {"key": key}


def _content(found: FleetReport) -> dict[str, Any]:
    from tierod.fleet.report import document

    content = document(found)
    ranks = {each["vehicle"]: each for each in content["cars"]}
    rows = _rows(found, ranks)
    quantities = [{name: value for name, value in each.items() if name != "levels"} for each in content["quantities"]]
    return {**content, "quantities": quantities, "rows": rows, "bands": _bands(found, list(ranks))}


def _rows(found: FleetReport, ranks: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """One row per car, cars with a reason first."""
    import pyarrow as pa
    import pyarrow.compute as pc

    from tierod.fleet.report import step
    from tierod.fleet.standing import JUDGED

    counts = found.findings.group_by("vehicle").aggregate([("start", "max"), ("recording_name", "count_distinct")])
    drives = {
        name: (count, None if last is None else last.isoformat())
        for name, count, last in zip(
            counts["vehicle"].to_pylist(), counts["recording_name_count_distinct"].to_pylist(),
            counts["start_max"].to_pylist(), strict=True,
        )
    }  # fmt: skip
    levels: dict[str, dict[str, Any]] = {}
    first = found.trends[0] if found.trends else None
    if first is not None:
        for place, vehicle in enumerate(first.series.vehicles):
            level, deviation = first.stated(place)
            levels[vehicle] = {
                "level": level, "deviation": deviation, "limit": first.series.limit[place],
                "step": step(first, place), "chance": first.chance[place],
                "cohort": {kind: names[place] for kind, names in first.series.labels.items() if names[place]},
            }  # fmt: skip
    verdicts = pc.is_in(found.findings["status"], pa.array([str(each) for each in JUDGED]))
    judged = set(found.findings["vehicle"].filter(verdicts).to_pylist())
    before = {each.vehicle: each.history for each in reversed(found.recovered)}
    order = list(ranks) + sorted(set(pc.unique(found.findings["vehicle"]).to_pylist()) - set(ranks) - {None})
    rows = []
    for place, vehicle in enumerate(order):
        car = ranks.get(vehicle)
        count, last = drives.get(vehicle, (0, None))
        rows.append({
            "rank": place + 1, "vehicle": vehicle, "state": car["state"] if car else "",
            "summary": car["summary"] if car else "" if vehicle in judged else "no verdict",
            "why": car["reasons"][0]["text"] if car else before.get(vehicle, ""),
            "inspect": car["reasons"][0]["inspect"] if car else "",
            "drives": count, "last": last, **levels.get(vehicle, {}),
        })  # fmt: skip
    return rows


def _bands(found: FleetReport, worst: Sequence[str]) -> dict[str, dict[str, Any]]:
    bands: dict[str, dict[str, Any]] = {}
    chosen = set(worst[:BANDS])
    for place, trends in enumerate(found.trends):
        own = bands.setdefault(str(place), {})
        for car, vehicle in enumerate(trends.series.vehicles):
            if vehicle in chosen:
                day, level, deviation = trends.band(car)
                # A chart has one value at a time: the level before a step ends just before it.
                day = day - 1e-3 * np.append(np.diff(day) == 0.0, False)
                own[vehicle] = {
                    "day": np.round(day, 3), "level": level, "deviation": deviation, "began": trends.began[car],
                    "alarmed": trends.alarmed[car], "stepped": trends.stepped(car),
                }  # fmt: skip
    return bands


class Fleets:
    """Computed fleet reports in memory, so that a table is filtered without delay."""

    def __init__(self, cache: Path):
        self._cache = cache
        self._lock = threading.Lock()
        self._loaded: dict[str, dict[str, Any]] = {}

    def loaded(self, key: str) -> dict[str, Any] | None:
        """A computed fleet report; None if it has not been computed yet."""
        with self._lock:
            if key not in self._loaded:
                try:
                    content = json.loads(path_of(self._cache, key).read_text(encoding="utf-8"))
                except (OSError, ValueError):
                    return None
                while len(self._loaded) >= 4:
                    del self._loaded[next(iter(self._loaded))]
                self._loaded[key] = content
            return self._loaded[key]


def filtered(
    rows: Sequence[Mapping[str, Any]], search: str = "", state: str = "", cohort: str = "", sort: str = "rank"
) -> list[Mapping[str, Any]]:
    """Rows that match the filters, in the requested order; rows without a value in the column come last."""
    wanted, (kind, _, name) = search.casefold(), cohort.partition("=")
    found = [
        row
        for row in rows
        if (not wanted or wanted in row["vehicle"].casefold() or wanted in row["why"].casefold())
        and (not state or (row["state"] if state == "any" else row["state"] == state))
        and (not cohort or (row.get("cohort") or {}).get(kind) == name)
    ]
    column = sort.lstrip("-")
    if column not in ("rank", "vehicle", "state", "drives", "last", "level", "chance", "deviation"):
        raise InputError(
            f"the table has no column '{column[:40]}'; sort by rank, vehicle, drives, last, level or chance"
        )
    known = [row for row in found if row.get(column) not in (None, "")]
    known.sort(key=lambda row: row[column], reverse=sort.startswith("-"))
    return known + [row for row in found if row.get(column) in (None, "")]


def drives_of(results: Path, vehicle: str) -> list[dict[str, Any]]:
    """All findings of a car, in the order of time."""
    import pyarrow.compute as pc

    from tierod.fleet.results import findings_of
    from tierod.report.document import plain

    names = ["vehicle", "recording_name", "start", "start_s", "mileage_m", "temperature_K", "monitor", "judged", "kind",
             "quantity", "unit", "status", "since_s", "declared_s", "end_s", "estimate", "deviation", "nominal",
             "limit", "cause", "action", "key", "cohort", "span"]  # fmt: skip
    table = findings_of(results, names)
    table = table.filter(pc.field("vehicle") == vehicle)
    if not len(table):
        raise Absent(f"the results have no vehicle '{vehicle[:100]}'; choose one from the table")
    rows: list[dict[str, Any]] = plain([
        {**row, "start": row["start"] and row["start"].timestamp(), "cohort": dict(row["cohort"] or ())}
        for row in table.to_pylist()
    ])  # fmt: skip
    return rows
