"""One page, one table and one JSON document of several recordings and monitors."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Sequence
from typing import Any

from tierod.core.content import Table
from tierod.core.findings import Diagnosis, Status
from tierod.monitors.several import Judged
from tierod.report.analysis.analysis import Analysis
from tierod.report.charts.elements import state_figure
from tierod.report.charts.over_time import estimate_figures
from tierod.report.display import evidence, interval
from tierod.report.document import document
from tierod.report.html import Origin, Section, rendered
from tierod.report.verdict import appearance, deciding, overall, shown_as

SCHEMA = "tierod.diagnoses/1"
"""Name and version of the JSON document."""

_RANK = {0: 0, 2: 1, 1: 2}
"""Exit codes from the best to the worst: healthy, could not judge, fault."""

HEADER = ("recording", "monitor", "verdict", "why")


def worst(judged: Sequence[Judged]) -> Status:
    """The worst status of all: a fault before what could not be judged, that before healthy."""
    found = [overall(each) for one in judged for each in one.diagnoses.values()]
    return max(found, key=lambda status: _RANK[status.exit_code], default=Status.NOT_AVAILABLE)


def overview(judged: Sequence[Judged]) -> list[tuple[str, str, str, str]]:
    """Rows of recording, monitor, verdict and headline; monitors that did not run stand apart."""
    return [
        (one.path.name, name, _verdict(each), each.findings[0].headline if each.findings else "")
        for one in judged
        for name, each in one.diagnoses.items()
    ]


def not_run(judged: Sequence[Judged]) -> list[tuple[str, str, str]]:
    """Rows of recordings, monitor and reason; recordings that lack the same are one row."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for one in judged:
        for monitor, reason in one.not_run:
            reasons.setdefault((monitor, reason), []).append(one.path.name)
    return [
        ("all" if len(names) == len(judged) else ", ".join(names), monitor, reason)
        for (monitor, reason), names in reasons.items()
    ]


def render(judged: Sequence[Judged], origin: Origin) -> str:
    """The page as text.

    Args:
        judged: the recordings
        origin: how the page came about
    """
    status = worst(judged)
    count = sum(len(one.diagnoses) for one in judged)
    words = f"the worst of {count} verdicts on {len(judged)} recordings" if count > 1 else "the only verdict"
    summary = (f"{appearance(status).symbol} {str(status).upper()}: {words}.",)
    overall_parts: list[tuple[str, Any]] = [
        ("table", Table("Verdicts", HEADER, tuple(overview(judged)))),
    ]
    if missed := not_run(judged):
        overall_parts.append(
            ("table", Table("Monitors that did not run", ("recording", "monitor", "why"), tuple(missed)))
        )
    sections = [Section("", (), overall_parts), *_sections(judged)]
    vehicles = ", ".join(dict.fromkeys(one.vehicle for one in judged))
    return rendered(
        "analysis.html.j2",
        origin,
        sections=sections,
        analysis=Analysis("All monitors", summary, (), {}),
        kind="diagnosis",
        facts_of=[("vehicle", vehicles), ("recordings", ", ".join(one.path.name for one in judged))],
        not_good_for=(),
    )


def _verdict(diagnosis: Diagnosis) -> str:
    if not diagnosis.findings:
        return f"{appearance(Status.NOT_AVAILABLE).symbol} {str(Status.NOT_AVAILABLE).upper()}"
    decisive = diagnosis.findings[0]
    return f"{shown_as(decisive).symbol} {decisive.shown_status.upper()}"


def _sections(judged: Sequence[Judged]) -> Iterator[Section]:
    for place, one in enumerate(judged):
        for name, each in one.diagnoses.items():
            yield _section(f"{one.path.name}, {name}: {_verdict(each)}", each, f"{place}-{name}")


def _section(title: str, diagnosis: Diagnosis, suffix: str) -> Section:
    """What a monitor found in a recording: texts, figures, charts of states and estimates."""
    texts: list[str] = []
    figures: list[tuple[str, str]] = []
    for finding in diagnosis.findings:
        texts += filter(None, (finding.headline, finding.cause, finding.action, *finding.warnings))
        texts += deciding(diagnosis, finding)
        if finding.estimate is not None:
            value, low, high, unit = interval(finding.estimate)
            figures.append((finding.estimate.quantity, f"{value} {unit} (95 %: {low} to {high})"))
        figures += [evidence(key, value) for key, value in finding.evidence.items()]
    rows = [(row.name, remark) for row in diagnosis.quality for remark in row.remarks]
    parts: list[tuple[str, Any]] = [("table", Table("Figures", ("figure", "value"), tuple(figures)))] if figures else []
    if rows:
        parts.append(("table", Table("Remarks on the data", ("channel", "remark"), tuple(rows))))
    charts = [*filter(None, [state_figure(diagnosis)]), *estimate_figures(diagnosis)]
    parts += [("chart", dataclasses.replace(each, name=f"{each.name}-{suffix}")) for each in charts]
    return Section(title, tuple(dict.fromkeys(texts)), parts)


def to_json(judged: Sequence[Judged], origin: Origin) -> str:
    """One JSON document: of every recording the documents of its diagnoses, and the monitors that did not run.

    Args:
        judged: the recordings
        origin: how it came about
    """
    status = worst(judged)
    content = {
        "schema": SCHEMA,
        "version": origin.version,
        "created": origin.created,
        "command": origin.command,
        "status": str(status),
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
