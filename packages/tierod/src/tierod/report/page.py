"""Page of a diagnosis: verdicts with gauges of their estimates, charts and tables."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import Any

from tierod.core.findings import Diagnosis, Estimate, Finding
from tierod.core.shown import shown, written
from tierod.core.timestamps import CALENDAR
from tierod.report.charts.decisions import decision_figure, design_figures, looks_figure, quiet_figure
from tierod.report.charts.distributions import histogram_figure, loop_figure
from tierod.report.charts.elements import state_figure, substitute_figures
from tierod.report.charts.figure import BLUE, GREY, PAPER, Figure, drawn_from, level_colour
from tierod.report.charts.over_time import estimate_figures, innovation_figure, result_figure, signal_figure
from tierod.report.display import INTERVAL, date, duration, evidence, interval, number, share, words
from tierod.report.html import UNFOLDED, Origin, rendered
from tierod.report.packing import packed_series
from tierod.report.verdict import (
    COLUMNS,
    EFFECT_COLUMNS,
    EFFECT_HEADING,
    dated,
    deciding,
    effect_rows,
    measure_first,
    rows,
)

_WIDTH, _MARGIN = 640.0, 14.0
_ROW = 26.0
_LETTER = 13.0
"""Width of a letter on the narrowest screen, for which labels are placed without overlap."""


def gauge(estimate: Estimate) -> str:
    """SVG drawing of an estimate on a scale with its reference levels; "" without a value or without levels."""
    factor, label = shown(estimate.unit)
    levels = sorted((level * factor, name) for name, level in estimate.reference.items() if math.isfinite(level))
    value, half = estimate.value * factor, INTERVAL * estimate.standard_deviation * factor
    if not levels or not math.isfinite(value):
        return ""
    half = half if math.isfinite(half) else 0.0
    high = 1.15 * max(value + half, levels[-1][0])
    low = min(0.0, 1.15 * (value - half), 1.15 * levels[0][0])

    def at(position: float) -> float:
        return _MARGIN + (_WIDTH - 2.0 * _MARGIN) * (position - low) / (high - low)

    marks = _placed(
        [(at(level), f"{words(name).lower()} {number(level, 3)}", level_colour(name)) for level, name in levels]
    )
    above = max((row for *_, row in marks if row > 0), default=0)
    below = max((-row for *_, row in marks if row < 0), default=0)
    line = 22.0 + _ROW * above
    parts = [_line(_MARGIN, line, _WIDTH - _MARGIN, line, GREY, 6.0)]
    parts += [_tick(x, colour, row, line) for x, _, colour, row in marks]
    parts += [_label(x, text, colour, row, line) for x, text, colour, row in marks]
    parts.append(_line(at(value - half), line, at(value + half), line, BLUE, 6.0))
    parts.append(
        f'<circle cx="{at(value):.1f}" cy="{line:.0f}" r="8" fill="{BLUE}" stroke="{PAPER}" stroke-width="2"/>'
    )
    size = f"0 0 {_WIDTH:.0f} {line + 22.0 + _ROW * below:.0f}"
    scale = ", ".join(text for _, text, _, _ in marks)
    middle, lower, upper, _ = interval(estimate)
    title = escape(f"{middle} {label} (95 % interval {lower} to {upper}) on a scale with {scale} {label}")
    return f'<svg class="gauge" viewBox="{size}" role="img" aria-label="{title}">{"".join(parts)}</svg>'


def _placed(marks: list[tuple[float, str, str]]) -> list[tuple[float, str, str, int]]:
    """Marks with their rows: 1, 2, ... above the line, -1, -2, ... below it, each in the nearest free row."""
    ends: dict[int, float] = {}
    placed = []
    for x, text, colour in marks:
        width = _LETTER * len(text)
        start = min(max(x - 0.5 * width, 0.0), _WIDTH - width)
        rows = (sign * row for row in range(1, len(marks) + 1) for sign in (1, -1))
        row = next(row for row in rows if ends.get(row, -1.0) < start)
        ends[row] = start + width
        placed.append((x, text, colour, row))
    return placed


def _line(x1: float, y1: float, x2: float, y2: float, colour: str, width: float) -> str:
    place = f'x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"'
    return f'<line {place} stroke="{colour}" stroke-width="{width:g}"/>'


def _reach(row: int, line: float) -> float:
    """Height at which the tick of a mark meets its label."""
    return line - 14.0 - _ROW * (row - 1) if row > 0 else line + 14.0 - _ROW * (row + 1)


def _tick(x: float, colour: str, row: int, line: float) -> str:
    return _line(x, line - 14.0, x, line + 14.0, colour, 2.5) + _line(x, line, x, _reach(row, line), colour, 1.0)


def _label(x: float, text: str, colour: str, row: int, line: float) -> str:
    y = _reach(row, line) + (-8.0 if row > 0 else 20.0)
    width = _LETTER * len(text)
    anchor = "start" if x < 0.5 * width else "end" if x > _WIDTH - 0.5 * width else "middle"
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{escape(text)}</text>'


NOTHING_RAN = (
    "What to do: 'tierod inspect' with the recording shows which signals it has and what each monitor lacks; a channel "
    "map (--map) gives signals under other names."
)

LATEST = 2.5e11
"""Latest plausible calendar time [s since 1970]; later ones are beyond any calendar year."""


@dataclass(frozen=True)
class Verdict:
    """One finding in the form shown on the page."""

    finding: Finding
    since: str
    value: str
    interval: str
    gauge: str
    evidence: list[tuple[str, str]]
    deciding: list[str]


def render(diagnosis: Diagnosis) -> str:
    """HTML page of a diagnosis."""
    figures = _figures(diagnosis)
    drawn = list(_all(figures))
    # Quiet statistics and rule designs are in a fold of their own, so they are not folded individually.
    in_fold = {name: figures[name] for name in ("quiet", "designs")}
    path = str(diagnosis.recording.get("path", "recording"))
    packed = packed_series(diagnosis.traces, sorted(set().union(*(drawn_from(m) for f in drawn for m in f.data))))
    return rendered(
        "report.html.j2",
        Origin(diagnosis.created, diagnosis.version, diagnosis.command),
        drawn,
        packed,
        diagnosis=diagnosis,
        status=diagnosis.status,
        verdicts=[verdict(diagnosis, finding) for finding in diagnosis.findings],
        elements=[row for element in diagnosis.elements for row in rows(element)],
        element_columns=COLUMNS,
        effects=effect_rows(diagnosis),
        effect_columns=EFFECT_COLUMNS,
        effect_heading=EFFECT_HEADING,
        measure_first=measure_first(diagnosis),
        figures=figures,
        nothing_ran=NOTHING_RAN,
        folded={each.name for each in drawn[UNFOLDED:]} - {each.name for each in _all(in_fold)},
        quality=[_quality_row(row) for row in diagnosis.quality],
        parameters=[_parameter_row(row) for row in diagnosis.parameters if not _is_tuning(row)],
        tuning=[_parameter_row(row) for row in diagnosis.parameters if _is_tuning(row)],
        sources=sentence(", ".join(sorted({row[4] for row in diagnosis.parameters if _is_tuning(row)}))).rstrip("."),
        decisions=[
            (each.name, each.distance, each.rule, each.false_alarms, each.source) for each in diagnosis.decisions
        ],
        consistency=[evidence(name, value) for name, value in diagnosis.consistency.items()],
        name=str(diagnosis.recording.get("name") or Path(path).name),
        recording=_facts(diagnosis.recording),
        details=[row for key, value in diagnosis.recording.items() if _is_nested(value) for row in _flat(key, value)],
        vehicle=_facts(diagnosis.vehicle),
    )


def verdict(diagnosis: Diagnosis, finding: Finding) -> Verdict:
    """A finding as texts and numbers for the page."""
    decisive = [sentence(each) for each in deciding(diagnosis, finding)]
    value = spread = picture = ""
    if finding.estimate is not None:
        middle, low, high, unit = interval(finding.estimate)
        value = f"{middle} {unit}".strip()
        spread = f"{low} to {high} {unit}".strip() if low != "–" else "not known"
        picture = gauge(finding.estimate)
    figures = [evidence(name, figure) for name, figure in finding.evidence.items()]
    finding = replace(
        finding,
        headline=sentence(finding.headline),
        cause=sentence(finding.cause),
        action=sentence("nothing" if finding.action == "none" else finding.action),
        warnings=tuple(map(sentence, finding.warnings)),
        details=tuple(map(sentence, finding.details)),
    )
    return Verdict(finding, dated(finding), value, spread, picture, figures, decisive)


def sentence(text: str) -> str:
    """Text with initial capital and full stop, and with non-breaking spaces between numbers and units."""
    text = re.sub(r"(?<=[\d±]) (?=N·m|km/h|m/s|Hz|[%°±]|(?<=± )\d)", "\N{NO-BREAK SPACE}", text.strip())
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith(('.', '!', '?')) else '.'}" if text else ""


def _figures(diagnosis: Diagnosis) -> dict[str, Any]:
    """All charts in the order of the page; lists for some kinds, and None where there is nothing to show."""
    return {
        "states": state_figure(diagnosis),
        "substitutes": substitute_figures(diagnosis),
        "estimates": estimate_figures(diagnosis),
        "results": result_figure(diagnosis),
        "decisions": decision_figure(diagnosis),
        "looks": looks_figure(diagnosis),
        "loops": loop_figure(diagnosis),
        "histograms": histogram_figure(diagnosis),
        "innovations": innovation_figure(diagnosis),
        "signals": signal_figure(diagnosis),
        "quiet": quiet_figure(diagnosis),
        "designs": design_figures(diagnosis),
    }


def _all(figures: Mapping[str, Any]) -> Iterator[Figure]:
    for each in figures.values():
        yield from each if isinstance(each, list) else filter(None, [each])


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
    # Parameters are shown in SI units, as in the vehicle file; charts and texts use other units.
    factor, as_shown = shown(unit)
    label = f"{written(unit)} ({number(value * factor, 3)} {as_shown})" if factor != 1.0 else written(unit)
    return words(name), number(value, 5), label, "" if spread is None else number(spread, 3), source


def _facts(facts: Mapping[str, object]) -> list[tuple[str, str]]:
    """Rows of facts, without empty and nested values."""
    rows = []
    for name, value in facts.items():
        if name == "origin" and isinstance(value, int | float) and CALENDAR < value < LATEST:
            rows.append(("Began", date(value)))
        elif isinstance(value, list | tuple) and value and not _is_nested(value):
            rows.append((words(name), "; ".join(map(str, value))))
        elif name.endswith("_unit"):
            rows.append((words(name), written(str(value))))
        elif value not in (None, "") and not isinstance(value, list | tuple | dict):
            rows.append(evidence(name, value))
    return rows


def _is_nested(value: object) -> bool:
    inside = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    return isinstance(value, dict) or any(isinstance(entry, dict | list | tuple) for entry in inside)


def _flat(name: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from _flat(f"{name}.{key}", entry)
    else:
        yield name, number(value, 6) if isinstance(value, float) else str(value)


def _is_tuning(row: tuple[str, float, str, float | None, str]) -> bool:
    return row[4].startswith("tuning of")
