"""Common parts of charts: figures as plain data, axes, bands with gaps, marks, and initial axis ranges."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np

from tierod.core.findings import Diagnosis, Estimate, Trace
from tierod.core.series import runs
from tierod.core.shown import shown
from tierod.report.display import INTERVAL, interval, number, words

BLUE, GREY, GREEN, AMBER, RED = "var(--accent)", "var(--grey)", "var(--good)", "var(--warn)", "var(--bad)"
# CSS variables of tokens.css, resolved by the script of the page
TEXT, GRID, PAPER, LINE = "var(--ink)", "var(--grid)", "var(--paper)", "var(--line)"

LABEL_GROUND = "var(--label)"  # Background of labels that cover a curve

Summary = tuple[str, ...]  # One row of the table below a chart: series, lowest, mean, highest


@dataclass(frozen=True)
class Figure:
    name: str
    title: str  # title, caption: heading, and a line on how to read the chart
    caption: str
    alternative: str  # text alternative in a sentence
    data: list[dict[str, Any]]  # data, layout: marks and layout in the format of plotly
    layout: dict[str, Any]
    height: int  # height in CSS pixels
    summary: Sequence[Summary] = ()  # rows of the table below the chart
    timed: bool = False  # whether its horizontal axis is the time of the recording, which all such charts zoom together
    columns: tuple[str, str, str, str] = field(default=("series", "lowest", "mean", "highest"))
    reading: str = ""  # further explanation, shown on request


def layout(height: int, **more: Any) -> dict[str, Any]:
    return {
        "height": height,
        "autosize": True,
        "margin": {"l": 62, "r": 14, "t": 30 if more.get("showlegend") is False else 58, "b": 44},
        "paper_bgcolor": PAPER,
        "plot_bgcolor": PAPER,
        "font": {"family": "system-ui, sans-serif", "size": 13, "color": TEXT},
        "hovermode": "closest",
        "hoversubplots": "axis",
        "hoverlabel": {"bgcolor": PAPER, "bordercolor": GREY, "font": {"color": TEXT}},
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "bgcolor": "rgba(0,0,0,0)"},
    } | more


def axis(title: str = "", **more: Any) -> dict[str, Any]:
    """Properties common to all axes."""
    shared = {"gridcolor": GRID, "linecolor": GREY, "zerolinecolor": LINE, "ticks": "outside", "tickcolor": GREY}
    return shared | {"title": {"text": title, "standoff": 8}} | more


def rounded(values: Sequence[float] | np.ndarray, digits: int = 5) -> list[float | None]:
    """Values rounded to the given digits of the largest one; values that are not finite become gaps."""
    given = np.asarray(values, float)
    finite = np.isfinite(given)
    largest = float(np.max(np.abs(given), where=finite, initial=0.0))
    places = digits - 1 - math.floor(math.log10(largest)) if largest > 0.0 else 0
    # np.round computes 10**places, which must not overflow.
    shown = np.round(given, min(max(places, -300), 300)).tolist()
    return [value if seen else None for value, seen in zip(shown, finite.tolist(), strict=True)]


def centres(trace: Trace, factor: float) -> np.ndarray:
    """Centre of each bin on the time axis."""
    time = np.asarray(trace.time, float)
    width = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    return (time + 0.5 * width) * factor


def drawn_as(part: str, trace: Trace, per_second: float, factor: float = 1.0, **more: Any) -> dict[str, Any]:
    """Origin of a mark in a series, from which the page redraws it at the resolution of the zoom."""
    unit = shown(trace.unit)[1]
    return {
        "meta": {"series": trace.name, "part": part, "per_second": per_second, "factor": factor, "unit": unit} | more
    }


def drawn_from(mark: Mapping[str, Any]) -> set[str]:
    """Names of the series from which a mark is drawn; empty for none."""
    meta = mark.get("meta", {})
    return {*meta.get("rows", ()), *(meta[key] for key in ("series", "deviation") if key in meta)}


def band(time: np.ndarray, lower: np.ndarray, upper: np.ndarray, colour: str, **more: Any) -> dict[str, Any]:
    """Filled band that is interrupted where an edge is missing: one closed outline per stretch without a gap."""
    across: list[float | None] = []
    along: list[float | None] = []
    begins, ends = runs(np.isfinite(lower) & np.isfinite(upper))
    for start, stop in zip(begins.tolist(), ends.tolist(), strict=True):
        part = slice(start, stop)
        across += [*rounded(time[part], 7), *rounded(time[part][::-1], 7), None]
        along += [*rounded(upper[part]), *rounded(lower[part][::-1]), None]
    looks = {"type": "scatter", "mode": "lines", "fill": "toself", "fillcolor": colour, "line": {"width": 0}}
    return looks | {"x": across[:-1], "y": along[:-1], "hoverinfo": "skip"} | more


def line(time: np.ndarray, values: np.ndarray, colour: str, name: str, **more: Any) -> dict[str, Any]:
    looks = {"type": "scatter", "mode": "lines", "line": {"color": colour, "width": 1.6}, "name": name}
    return looks | {"x": rounded(time, 7), "y": rounded(values), "connectgaps": False} | more


def across(height: float, colour: str, width: float, dash: str = "dash", **more: Any) -> dict[str, Any]:
    """Horizontal line across the whole chart."""
    ends = {"xref": "paper", "x0": 0, "x1": 1, "y0": height, "y1": height}
    return {"type": "line", "line": {"color": colour, "width": width, "dash": dash}} | ends | more


def upright(place: float, colour: str, width: float, dash: str = "dash", **more: Any) -> dict[str, Any]:
    """Vertical line across the whole chart."""
    ends = {"yref": "paper", "y0": 0, "y1": 1, "x0": place, "x1": place}
    return {"type": "line", "line": {"color": colour, "width": width, "dash": dash}} | ends | more


def strip(trace: Trace, per_second: float, factor: float, label: str, axis_name: str) -> list[dict[str, Any]]:
    """A trace as a thin line of its mean in a band from lowest to highest value."""
    time, name = centres(trace, per_second), words(trace.name)
    lower, upper, mean = (np.asarray(part, float) * factor for part in (trace.lower, trace.upper, trace.mean))
    text = {"hovertemplate": "%{y:.4g} " + label + f"<extra>{name}</extra>"}
    within, middle = (drawn_as(part, trace, per_second, factor) for part in ("range", "mean"))
    return [
        band(time, lower, upper, BLUE, opacity=0.3, yaxis=axis_name, **within),
        line(time, mean, BLUE, name, yaxis=axis_name, **text, **middle) | {"line": {"color": BLUE, "width": 1.0}},
    ]


def level_colour(name: str) -> str:
    for word, colour in (("fault", RED), ("rising", AMBER), ("nominal", GREEN), ("learnt", GREEN)):
        if word in name.lower():
            return colour
    return GREY


def references(diagnosis: Diagnosis, unit: str) -> list[tuple[str, float]]:
    """(name, displayed level) of the references of the decisive estimate; empty if its unit differs."""
    estimate = diagnosis.findings[0].estimate if diagnosis.findings else None
    if estimate is None or estimate.unit != unit:
        return []
    return [(name, value * shown(unit)[0]) for name, value in estimate.reference.items() if np.isfinite(value)]


def strip_title(text: str, top: float) -> dict[str, Any]:
    """Title above one of several strips; `top` is the upper end of the strip as a share of the chart."""
    place = {"xref": "paper", "x": 0, "xanchor": "left", "yref": "paper", "y": top, "yanchor": "bottom"}
    return {"text": text, "showarrow": False, "font": {"size": 12.5}} | place


def summary(name: str, trace: Trace, factor: float, label: str) -> Summary:
    """Table row of one series below its chart."""
    parts = []
    for values, reduce in ((trace.lower, np.min), (trace.mean, np.mean), (trace.upper, np.max)):
        seen = np.asarray(values, float)[np.isfinite(values)]
        parts.append(f"{number(float(reduce(seen)) * factor)} {label}".strip() if len(seen) else "–")
    return name, parts[0], parts[1], parts[2]


def first_range(mean: np.ndarray, upper: np.ndarray, outer: np.ndarray, levels: list[float]) -> list[float]:
    """Lowest and highest value of the initial axis range."""
    return _both_ways(mean, levels) if _has_both_signs(mean) else _top(upper, outer, levels)


def _top(upper: np.ndarray, outer: np.ndarray, levels: list[float]) -> list[float]:
    """Initial range with all levels and 98 % of the band, which starts wide before the estimator has converged."""
    seen = np.concatenate([upper[np.isfinite(upper)], outer[np.isfinite(outer)]])
    high = max([*levels, float(np.quantile(seen, 0.98)) if len(seen) else 1.0])
    low = min(0.0, float(np.quantile(upper[np.isfinite(upper)], 0.02)) if np.isfinite(upper).any() else 0.0)
    return [1.1 * low, 1.15 * high or 1.0]


def _has_both_signs(mean: np.ndarray) -> bool:
    """Whether more than a tenth of the finite values is negative; rare negative values do not extend the range."""
    known = mean[np.isfinite(mean)]
    return bool(np.mean(known < 0.0) > 0.1) if len(known) else False


def _both_ways(mean: np.ndarray, levels: list[float]) -> list[float]:
    low, high = np.nanmin(mean), max([*levels, np.nanmax(mean)])
    room = 0.08 * (high - low)
    return [float(low - room), float(high + room)]


_WIDTH, _MARGIN, _ROW = 640.0, 14.0, 26.0
_LETTER = 13.0  # Width of a letter on the narrowest screen, for which labels are placed without overlap


def gauge(estimate: Estimate) -> str:
    """SVG drawing; "" without a value or without levels."""
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
    parts += [_mark(*mark, line) for mark in marks]
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


def _mark(x: float, text: str, colour: str, row: int, line: float) -> str:
    reach = line - 14.0 - _ROW * (row - 1) if row > 0 else line + 14.0 - _ROW * (row + 1)
    y, half = reach + (-8.0 if row > 0 else 20.0), 0.5 * _LETTER * len(text)
    anchor = "start" if x < half else "end" if x > _WIDTH - half else "middle"
    return (
        _line(x, line - 14.0, x, line + 14.0, colour, 2.5)
        + _line(x, line, x, reach, colour, 1.0)
        + f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{escape(text)}</text>'
    )
