"""One page, one table and one JSON document for several recordings and monitors."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from tierod.core.content import Table
from tierod.core.findings import Diagnosis, Trace
from tierod.core.statuses import Status, worst
from tierod.monitors.several import ALL, Judged
from tierod.report.charts.decisions import decision_figure, looks_figure
from tierod.report.charts.elements import state_figure
from tierod.report.charts.figure import Figure, drawn_from
from tierod.report.charts.over_time import estimate_figures
from tierod.report.display import words
from tierod.report.document import document
from tierod.report.html import Looks, Origin, Section, rendered
from tierod.report.packing import packed_series
from tierod.report.page import NOTHING_RAN, sentence, verdict

SCHEMA = "tierod.diagnoses/2"
"""Name and version of the JSON document."""

HEADER = ("recording", "monitor", "verdict", "why")


def status_of(judged: Sequence[Judged]) -> Status:
    """Worst status of all; a recording without a verdict counts as not available."""
    # The worst of no diagnosis is "not available".
    return worst(worst(each.status for each in one.diagnoses.values()) for one in judged)


def overview(judged: Sequence[Judged]) -> list[tuple[str, str, Status, str]]:
    """Rows of recording, monitor, verdict and headline, without the monitors that did not run."""
    return [
        (one.path.name, name, each.status, each.decisive.headline if each.decisive else "")
        for one in judged
        for name, each in one.diagnoses.items()
    ]


def not_run(judged: Sequence[Judged]) -> list[tuple[str, str, str]]:
    """Rows of recordings, monitors and reason, with equal reasons grouped by monitors and by recordings."""
    rows: dict[tuple[str, str], list[str]] = {}
    for one in judged:
        monitors: dict[str, list[str]] = {}
        for monitor, reason in one.not_run:
            monitors.setdefault(reason, []).append(monitor)
        for reason, alike in monitors.items():
            whole = 1 < len(alike) == len(one.not_run) and not one.diagnoses
            rows.setdefault((ALL if whole else ", ".join(alike), reason), []).append(one.path.name)
    return [
        ("all" if len(names) == len(judged) else ", ".join(names), monitors, reason)
        for (monitors, reason), names in rows.items()
    ]


def to_know(judged: Sequence[Judged]) -> list[tuple[str, str, str]]:
    """Rows of recording, monitors and warning, with equal warnings of several monitors grouped."""
    monitors: dict[tuple[str, str], list[str]] = {}
    for one in judged:
        for name, diagnosis in one.diagnoses.items():
            for warning in dict.fromkeys(each for finding in diagnosis.findings for each in finding.warnings):
                monitors.setdefault((one.path.name, warning), []).append(name)
    return [(where, ", ".join(names), warning) for (where, warning), names in monitors.items()]


def render(judged: Sequence[Judged], origin: Origin) -> str:
    """HTML page of several diagnoses."""
    verdicts: list[tuple[str, Any]] = [("table", Table("Verdicts", HEADER, tuple(overview(judged))))]
    if missed := not_run(judged):
        verdicts.append(("table", Table("Monitors that did not run", ("recording", "monitor", "why"), tuple(missed))))
    traces: dict[str, Trace] = {}
    parts = [Section("All verdicts", (), verdicts), *_sections(judged, traces)]
    drawn = (mark for section in parts for kind, part in section.parts if kind == "chart" for mark in part.data)
    packed = packed_series(traces, sorted(set().union(*map(drawn_from, drawn))))
    vehicles = ", ".join(dict.fromkeys(one.vehicle for one in judged))
    return rendered(
        "analysis.html.j2",
        origin,
        (),
        packed,
        sections=parts,
        **_head(judged),
        kind="diagnosis",
        facts_of=[("Vehicle", vehicles), ("Recordings", ", ".join(one.path.name for one in judged))],
    )


def _head(judged: Sequence[Judged]) -> dict[str, Any]:
    """Headline of the page: the worst verdict, and the number of verdicts of which it is the worst."""
    found = [each for one in judged for each in one.diagnoses.values()]
    missed = [one.path.name for one in judged if not one.diagnoses]
    status = status_of(judged)
    looks = Looks.of(status)
    decisive = next((each.decisive for each in found if each.decisive and each.status is status), None)
    if decisive is None:
        if not found:
            return {"looks": looks, "title": "No monitor ran on these recordings.", "summary": (NOTHING_RAN,)}
        title = f"{len(missed)} of {len(judged)} recordings could not be judged: {', '.join(missed)}."
        return {"looks": looks, "title": title, "summary": ("In the others no monitor declares a fault.",)}
    over = f"{len(judged) - len(missed)} recordings" if len(judged) > 1 else "the recording"
    summary = [f"The worst of {len(found)} verdicts on {over}."] if len(found) > 1 else []
    summary += [f"Not judged: {', '.join(missed)}."] if missed else []
    return {"looks": looks, "title": sentence(decisive.headline), "summary": summary}


def _sections(judged: Sequence[Judged], traces: dict[str, Trace]) -> Iterator[Section]:
    """A section per diagnosis; its series are added to `traces` under unique names."""
    for place, one in enumerate(judged):
        for name, each in one.diagnoses.items():
            where = f"{one.path.name}, {name}" if len(judged) > 1 else name
            traces |= {f"{place}-{name}/{key}": trace for key, trace in each.traces.items()}
            yield _section(f"{where}: {each.status.capitals}", each, f"{place}-{name}")


def _section(title: str, diagnosis: Diagnosis, suffix: str) -> Section:
    """Section on one diagnosis: verdicts, remarks on the data, and charts."""
    parts: list[tuple[str, Any]] = [("verdict", verdict(diagnosis, each)) for each in diagnosis.findings]
    if rows := [(words(row.name), remark) for row in diagnosis.quality for remark in row.remarks]:
        parts.append(("table", Table("Remarks on the data", ("channel", "remark"), tuple(rows))))
    charts = [
        state_figure(diagnosis),
        *estimate_figures(diagnosis),
        decision_figure(diagnosis),
        looks_figure(diagnosis),
    ]
    parts += [("chart", _apart(each, suffix)) for each in charts if each]
    headlines = tuple(sentence(each.headline) for each in diagnosis.findings)
    return Section(title, headlines, parts, diagnosis.status.colour)


def _apart(figure: Figure, suffix: str) -> Figure:
    """A chart with a unique name, drawn from uniquely named series."""

    def own(meta: Mapping[str, Any]) -> dict[str, Any]:
        names = {key: f"{suffix}/{meta[key]}" for key in ("series", "deviation") if key in meta}
        rows = {"rows": [f"{suffix}/{name}" for name in meta["rows"]]} if "rows" in meta else {}
        return {**meta, **names, **rows}

    data = [mark | {"meta": own(mark["meta"])} if "meta" in mark else mark for mark in figure.data]
    return dataclasses.replace(figure, name=f"{figure.name}-{suffix}", data=data)


def to_json(judged: Sequence[Judged], origin: Origin) -> str:
    """JSON document with the diagnoses of every recording and the monitors that did not run.

    Args:
        judged: recordings with their diagnoses
        origin: time, version and command
    """
    status = status_of(judged)
    content = {
        "schema": SCHEMA,
        "version": origin.version,
        "created": origin.created,
        "command": origin.command,
        **status.document(),
        "exit_code": status.exit_code,
        "recordings": [
            {
                "path": str(one.path),
                "vehicle": one.vehicle,
                "diagnoses": {name: json.loads(document(each, False)) for name, each in one.diagnoses.items()},
                "not_run": [{"monitor": name, "reason": reason} for name, reason in one.not_run],
            }
            for one in judged
        ],
    }
    return json.dumps(content, ensure_ascii=False, indent=2, allow_nan=False)
