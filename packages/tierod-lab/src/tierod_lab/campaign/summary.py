"""Summary of a campaign: rows, figures of every group, gates, and a document of all results."""

from __future__ import annotations

import dataclasses
import datetime
import itertools
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, OutputError
from tierod.core.user_files import json_document
from tierod.core.version import __version__
from tierod_lab.campaign.campaign import Campaign
from tierod_lab.campaign.figures import CONFIDENCE, Moments
from tierod_lab.campaign.judging import Judged, Row, from_plain, json_value, matching
from tierod_lab.campaign.matrix import FAULT, FAULT_FREE, SEED, SIZE
from tierod_lab.campaign.plan import Judge
from tierod_lab.campaign.pools import Passed, boxes, confusion, pass_through, pool_at
from tierod_lab.campaign.store import Store

SCHEMA = "tierod.campaign/1"  # Name and version of the document

OPEN = "open"  # Outcome of a drive that has not been simulated yet

MET, MISSED, NOT_JUDGED, UNGATED = "met", "missed", "not judged", "no gates"
EXIT_CODES = {MET: 0, UNGATED: 0, MISSED: 1, NOT_JUDGED: 2}  # Exit code by the combined result of all gates


@dataclass(frozen=True)
class Summary:
    """Results of a campaign."""

    campaign: Campaign
    rows: tuple[Row, ...]  # row of every monitor and cell, in the order of the matrix
    gates: tuple[Passed, ...]

    @property
    def status(self) -> str:
        """Missed if one gate is missed; not judged if one gate or no drive at all could be judged."""
        found = {each.met for each in self.gates}
        if False in found:
            return MISSED
        if None in found or not any(row.judged for row in self.rows):
            return NOT_JUDGED
        return MET if found else UNGATED

    @property
    def exit_code(self) -> int:
        """Exit code of the command."""
        return EXIT_CODES[self.status]


def summarise(campaign: Campaign, store: Store) -> Summary:
    """Read the existing results; cells that are not simulated yet have rows too."""
    rows = tuple(row for judge in campaign.plan.judges for row in _rows(campaign, store, judge))
    return Summary(campaign, rows, tuple(pass_through(gate, rows) for gate in campaign.gates))


def _rows(campaign: Campaign, store: Store, judge: Judge) -> Iterator[Row]:
    none: dict[str, Any] = {"outcome": OPEN, "reason": "not driven yet", "last_good_s": None}
    none |= {"windows": [], "recording": None}
    for cell in campaign.plan.cells:
        drive = store.drive(cell.name, cell.key) or none
        verdict = campaign.plan.verdict(cell, judge, store)
        place = cell.point.place
        if drive["outcome"] != "driven":
            yield Row(place, drive, judge.label, None, drive["reason"])
        elif verdict is None:
            yield Row(place, drive, judge.label, None, "not judged yet")
        elif verdict["judged"] is None:
            yield Row(place, drive, judge.label, None, verdict["reason"])
        else:
            yield Row(place, drive, judge.label, from_plain(verdict["judged"]))


def groups(summary: Summary) -> list[dict[str, str]]:
    """Groups with own figures: all drives, every level of every axis but seeds, and every fault with its magnitude."""
    axes = {axis: levels for axis, levels in summary.campaign.axes.items() if axis not in (SEED, SIZE)}
    single = [{axis: level} for axis, levels in axes.items() if len(levels) > 1 or axis == FAULT for level in levels]
    sized = dict.fromkeys((row.place[FAULT], row.place[SIZE]) for row in summary.rows if row.place[SIZE])
    faults = [{FAULT: fault, SIZE: size} for fault, size in sized]
    wide = [axis for axis, levels in axes.items() if axis != FAULT and len(levels) > 1]
    crossed = [
        {axis: level} | fault
        for axis in wide
        for level, fault in itertools.product(
            axes[axis], faults or [{FAULT: f} for f in axes[FAULT] if f != FAULT_FREE]
        )
    ]
    return [{}, *single, *faults, *crossed]


def document(summary: Summary, command: str = "") -> dict[str, Any]:
    """The campaign as a JSON document; values that JSON cannot represent are null (none) or "inf" (never)."""
    campaign = summary.campaign
    cells: dict[int, list[Row]] = {}
    for row in summary.rows:
        # Rows of one cell share the same place object.
        cells.setdefault(id(row.place), []).append(row)
    content = {
        "schema": SCHEMA,
        "version": __version__,
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "command": command,
        "name": campaign.file.name,
        "description": campaign.file.description,
        "status": summary.status,
        "exit_code": summary.exit_code,
        "confidence": CONFIDENCE,
        "text": campaign.document.text,
        "hours": campaign.hours,
        "axes": campaign.axes,
        "monitors": [
            {
                "label": judge.label,
                "monitor": judge.monitor,
                "variant": judge.variant,
                "vehicle": judge.belief.name,
                "baseline": "first fault-free drive" if judge.learns else "none",
            }
            for judge in campaign.plan.judges
        ],
        "gates": [_gate(each) for each in summary.gates],
        "pools": [
            {"monitor": judge.label, "where": where, "figures": pool_at(summary.rows, where, judge.label)._asdict()}
            for judge in campaign.plan.judges
            for where in groups(summary)
        ],
        "states": [_states(summary, judge.label) for judge in campaign.plan.judges],
        "cells": [_cell(rows) for rows in cells.values()],
    }
    plain: dict[str, Any] = json_value(content)
    return plain


def _gate(passed: Passed) -> dict[str, Any]:
    gate = passed.gate
    return {
        "name": gate.name,
        "figure": gate.figure,
        "where": dict(gate.where),
        "monitor": gate.monitor,
        "goal": str(gate.goal),
        "measured": passed.measured,
        "met": passed.met,
        "note": passed.note,
    }


def _states(summary: Summary, monitor: str) -> dict[str, Any]:
    rows = matching(summary.rows, {}, monitor)
    return {
        "monitor": monitor,
        "confusion": confusion(rows),
        "unit": next((row.judged.unit for row in rows if row.judged and row.judged.unit), ""),
        "boxes": [box._asdict() for box in boxes(rows)],
    }


def _cell(rows: Sequence[Row]) -> dict[str, Any]:
    row = rows[0]
    recording = row.drive["recording"]
    return {
        "place": dict(row.place),
        "given": row.given,
        "outcome": row.drive["outcome"],
        "reason": row.drive["reason"],
        "last_good_s": row.drive["last_good_s"],
        "recording": recording["file"] if recording else None,
        "verdicts": [_verdict(each) for each in rows],
    }


_SHOWN = ("status", "outcome", "headline", "value", "deviation", "detection_s", "detection_enabled_s", "false_alarms")


def _verdict(row: Row) -> dict[str, Any]:
    judged = row.judged
    content: dict[str, Any] = {"monitor": row.monitor, "reason": row.reason}
    if judged is None:
        return content | {"status": None}
    return content | {name: getattr(judged, name) for name in _SHOWN}


def text(content: Mapping[str, object]) -> str:
    return json.dumps(content, ensure_ascii=False, indent=1, allow_nan=False) + "\n"


COLUMNS_OF_DRIVE = ("given", "monitor", "outcome_of_drive", "reason", "last_good_s", "recording", "windows")
PROVENANCE = "provenance"  # Column with all data that reproduce the drive, as JSON


def write_table(rows: Sequence[Row], path: Path) -> None:
    """Write the table as Parquet; the names of axis columns start with "axis."."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from tierod.core.files import replacing

    columns = {name: [each[name] for each in map(_flat, rows)] for name in _names(rows)}
    table = pa.table({name: pa.array(values, _kind(pa, name)) for name, values in columns.items()})
    try:
        with replacing(path) as temporary:
            pq.write_table(table, temporary)
    except pa.ArrowException as error:
        raise OutputError(f"{path} cannot be written: {' '.join(str(error).split())[:160]}") from None


def read_table(path: Path) -> list[Row]:
    """The rows of a table; their drives contain the columns of the table."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    if not path.is_file():
        raise InputError(f"{path} is not there; name the folder of a campaign that has been run")
    try:
        rows = pq.read_table(path).to_pylist()
        return [_row(each) for each in rows]
    except (OSError, pa.ArrowException, KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{path} is not a table of a campaign ({reason}); run the campaign again") from None


AXIS = "axis."
_TEXTS = {"status", "headline", "cause", "unit", "outcome"}
_LISTS = {"estimates_fault_free", "estimates_faulty"}
_MOMENTS = ("errors_fault_free", "errors_faulty")
_PARTS = ("count", "mean", "squares")


def _judged_names() -> list[str]:
    names = []
    for field in dataclasses.fields(Judged):
        names += [f"{field.name}.{part}" for part in _PARTS] if field.name in _MOMENTS else [field.name]
    return names


def _names(rows: Sequence[Row]) -> list[str]:
    axes = dict.fromkeys(f"{AXIS}{axis}" for row in rows for axis in row.place)
    return [*axes, *COLUMNS_OF_DRIVE, *_judged_names(), PROVENANCE]


def _flat(row: Row) -> dict[str, Any]:
    recording = row.drive["recording"]
    flat: dict[str, Any] = {f"{AXIS}{axis}": level for axis, level in row.place.items()}
    flat |= {
        "given": row.given,
        "monitor": row.monitor,
        "outcome_of_drive": row.drive["outcome"],
        "reason": row.reason or None,
        "last_good_s": row.drive["last_good_s"],
        "recording": recording["file"] if recording else None,
        "windows": json.dumps(row.drive["windows"]),
        PROVENANCE: json.dumps(row.drive.get("provenance")),
    }
    for name in _judged_names():
        field, _, part = name.partition(".")
        value = None if row.judged is None else getattr(row.judged, field)
        flat[name] = value if value is None or not part else getattr(value, part)
    return flat


def _kind(pa: Any, name: str) -> Any:
    if name in _LISTS:
        return pa.list_(pa.float64())
    if name == "false_alarms" or name.endswith(".count"):
        return pa.int64()
    if name in _TEXTS or name in {*COLUMNS_OF_DRIVE, PROVENANCE} - {"last_good_s"} or name.startswith(AXIS):
        return pa.string()
    return pa.float64()


def _row(flat: dict[str, Any]) -> Row:
    place = {
        name.removeprefix(AXIS): level for name, level in flat.items() if name.startswith(AXIS) and level is not None
    }
    drive = {
        "outcome": flat["outcome_of_drive"],
        "reason": flat["reason"] or "",
        "last_good_s": flat["last_good_s"],
        "windows": json_document(flat["windows"]),
        "recording": None if flat["recording"] is None else {"file": flat["recording"]},
        "provenance": json_document(flat[PROVENANCE]),
    }
    judged = None if flat["status"] is None else from_plain(_nested(flat))
    return Row(place, drive, flat["monitor"], judged, "" if judged else flat["reason"] or "")


def _nested(flat: dict[str, Any]) -> dict[str, Any]:
    values = {field.name: flat.get(field.name) for field in dataclasses.fields(Judged)}
    for name in _MOMENTS:
        values[name] = dataclasses.asdict(Moments(*(flat[f"{name}.{part}"] for part in _PARTS)))
    return values


def monitors_of(rows: Iterable[Row]) -> list[str]:
    """Labels of the monitors, in order."""
    return list(dict.fromkeys(row.monitor for row in rows))
