"""Common parts of charts: figures as plain data, axes, bands with gaps, marks, and initial axis ranges."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tierod.core.findings import Diagnosis, Trace
from tierod.core.series import runs
from tierod.core.shown import shown
from tierod.report.display import number, words

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
