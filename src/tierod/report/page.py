"""Puts the page together: verdict, charts and tables, the charting library and the style all in one file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tierod.core.findings import Diagnosis, Finding
from tierod.core.shown import shown, written
from tierod.core.timestamps import CALENDAR
from tierod.report.charts.decisions import decision_figure, design_figures, looks_figure, quiet_figure
from tierod.report.charts.distributions import histogram_figure, loop_figure
from tierod.report.charts.elements import state_figure, substitute_figures
from tierod.report.charts.figure import Figure, drawn_from
from tierod.report.charts.over_time import estimate_figures, innovation_figure, result_figure, signal_figure
from tierod.report.display import date, duration, evidence, instant, interval, number, share, words
from tierod.report.gauge import gauge
from tierod.report.html import Origin, packed_series, rendered
from tierod.report.verdict import COLUMNS, appearance, deciding, overall, rows

LATEST = 2.5e11
"""Calendar times [s] beyond this are of no year that a calendar has."""


@dataclass(frozen=True)
class Verdict:
    """One finding as the page shows it."""

    finding: Finding
    symbol: str
    kind: str
    since: str
    value: str
    interval: str
    gauge: str
    evidence: list[tuple[str, str]]
    deciding: list[str]


def render(diagnosis: Diagnosis) -> str:
    """The page as text."""
    figures = {
        "states": state_figure(diagnosis),
        "substitutes": substitute_figures(diagnosis),
        "estimates": estimate_figures(diagnosis),
        "loops": loop_figure(diagnosis),
        "histograms": histogram_figure(diagnosis),
        "innovations": innovation_figure(diagnosis),
        "results": result_figure(diagnosis),
        "decisions": decision_figure(diagnosis),
        "looks": looks_figure(diagnosis),
        "quiet": quiet_figure(diagnosis),
        "designs": design_figures(diagnosis),
        "signals": signal_figure(diagnosis),
    }
    drawn = _all(figures)
    packed = packed_series(diagnosis.traces, sorted(set().union(*(drawn_from(m) for f in drawn for m in f.data))))
    return rendered(
        "report.html.j2",
        Origin(diagnosis.created, diagnosis.version, diagnosis.command),
        drawn,
        packed,
        diagnosis=diagnosis,
        status=overall(diagnosis),
        verdicts=[verdict(diagnosis, finding) for finding in diagnosis.findings],
        elements=[row for element in diagnosis.elements for row in rows(element)],
        element_columns=COLUMNS,
        figures=figures,
        quality=[_quality_row(row) for row in diagnosis.quality],
        parameters=[_parameter_row(row) for row in diagnosis.parameters if not _is_tuning(row)],
        tuning=[_parameter_row(row) for row in diagnosis.parameters if _is_tuning(row)],
        sources=_sentence(", ".join(sorted({row[4] for row in diagnosis.parameters if _is_tuning(row)}))).rstrip("."),
        decisions=[
            (each.name, each.distance, each.rule, each.false_alarms, each.source) for each in diagnosis.decisions
        ],
        consistency=[evidence(name, value) for name, value in diagnosis.consistency.items()],
        name=_name(diagnosis),
        recording=_facts(diagnosis.recording),
        details=[row for key, value in diagnosis.recording.items() if _is_nested(value) for row in _flat(key, value)],
        vehicle=_facts(diagnosis.vehicle),
    )


def verdict(diagnosis: Diagnosis, finding: Finding) -> Verdict:
    """A finding in words and figures."""
    decisive = [_sentence(each) for each in deciding(diagnosis, finding)]
    looks = appearance(finding.status)
    value = spread = picture = ""
    if finding.estimate is not None:
        middle, low, high, unit = interval(finding.estimate)
        value = f"{middle} {unit}".strip()
        spread = f"{low} to {high} {unit}".strip() if low != "–" else "not known"
        picture = gauge(finding.estimate)
    figures = [evidence(name, figure) for name, figure in finding.evidence.items()]
    finding = replace(
        finding,
        headline=_sentence(finding.headline),
        cause=_sentence(finding.cause),
        action=_sentence(finding.action),
        warnings=tuple(map(_sentence, finding.warnings)),
    )
    since = "" if finding.since is None else f"at {instant(finding.since)}" if finding.since > 0.0 else "at the start"
    return Verdict(finding, looks.symbol, looks.kind, since, value, spread, picture, figures, decisive)


def _sentence(text: str) -> str:
    """The text with a capital letter and a full stop; a number is not parted from its unit."""
    text = re.sub(r"(?<=[\d±]) (?=N·m|km/h|m/s|Hz|[%°±]|(?<=± )\d)", "\N{NO-BREAK SPACE}", text.strip())
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith(('.', '!', '?')) else '.'}" if text else ""


def _all(figures: dict[str, Any]) -> list[Figure]:
    several = ("substitutes", "estimates", "designs")
    lists = (figure for name in several for figure in figures[name])
    return [*lists, *(figure for key, figure in figures.items() if key not in several and figure)]


def _quality_row(row: Any) -> dict[str, Any]:
    factor, label = shown(row.unit)
    return {
        "name": words(row.name),
        "source": row.source,
        "unit": label,
        "samples": f"{row.samples:,}".replace(",", " "),
        "rate": number(row.rate, 3),
        "missing": share(row.missing_share),
        "gap": duration(row.longest_gap),
        "minimum": number(row.minimum * factor, 3),
        "maximum": number(row.maximum * factor, 3),
        "remarks": row.remarks,
    }


def _parameter_row(row: tuple[str, float, str, float | None, str]) -> tuple[str, str, str, str, str]:
    name, value, unit, spread, source = row
    # Parameters stay in SI, as in the vehicle file: an angle in degrees would not be found there again.
    label = written(unit)
    return words(name), number(value, 5), label, "" if spread is None else number(spread, 3), source


def _facts(facts: dict[str, Any]) -> list[tuple[str, str]]:
    """What is known of something, less what is empty or nested."""
    rows = []
    for name, value in facts.items():
        if name == "origin" and isinstance(value, int | float) and CALENDAR < value < LATEST:
            rows.append(("Began", date(value)))
        elif isinstance(value, list | tuple) and value and not _is_nested(value):
            rows.append((words(name), "; ".join(map(str, value))))
        elif value not in (None, "") and not isinstance(value, list | tuple | dict):
            rows.append(evidence(name, value))
    return rows


def _is_nested(value: Any) -> bool:
    inside = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    return isinstance(value, dict) or any(isinstance(entry, dict | list | tuple) for entry in inside)


def _flat(name: str, value: Any) -> Iterator[tuple[str, str]]:
    """(dotted name, value) of everything in nested metadata."""
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from _flat(f"{name}.{key}", entry)
    else:
        yield name, number(value, 6) if isinstance(value, float) else str(value)


def _is_tuning(row: tuple[str, float, str, float | None, str]) -> bool:
    return row[4].startswith("tuning of")


def _name(diagnosis: Diagnosis) -> str:
    return str(diagnosis.recording.get("name") or Path(str(diagnosis.recording.get("path", "recording"))).name)
