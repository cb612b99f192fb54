"""What a monitor decided on: statistics with their thresholds over time, and what the design of each rule trades."""

from __future__ import annotations

from typing import Any

import numpy as np

from tierod.decimation import merged
from tierod.findings import Decided, Diagnosis, Trace
from tierod.report.charts.figure import (
    BLUE,
    GREY,
    RED,
    Figure,
    axis,
    centres,
    drawn_as,
    layout,
    line,
    rounded,
    strip,
    strip_title,
    summary,
)
from tierod.report.charts.over_time import span
from tierod.report.display import bracketed, number, shown, time_scale, words

_STRIP, _PANEL = 130, 250
DELAY = "What fewer false alarms cost, at the shift that must be found; what the estimator takes comes on top"


def statistics(diagnosis: Diagnosis) -> dict[str, tuple[float, ...]]:
    """The traces that rules compare, with their thresholds: several rules may share one."""
    found: dict[str, tuple[float, ...]] = {}
    for each in diagnosis.decisions:
        if each.statistic in diagnosis.traces:
            found[each.statistic] = (*found.get(each.statistic, ()), *each.levels)
    return found


def decision_figure(diagnosis: Diagnosis) -> Figure | None:
    """Every statistic over time, its thresholds dashed, red where it is beyond one."""
    found = statistics(diagnosis)
    if not found:
        return None
    per_second, clock = time_scale(span(diagnosis)[1] - span(diagnosis)[0])
    height = _STRIP * len(found) + 70
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    shapes, rows, titles = [], [], []
    for index, (name, levels) in enumerate(found.items()):
        trace = merged(diagnosis.traces[name])
        factor, label = shown(trace.unit)
        suffix = "" if index == 0 else str(index + 1)
        domain = [1.0 - (index + 1) / len(found), 1.0 - index / len(found) - 26.0 / height]
        axes[f"yaxis{suffix}"] = axis("", domain=domain, nticks=4)
        limits = [level * factor for level in levels]
        data += _strip(trace, per_second, factor, label, levels, f"y{suffix}")
        shapes += [_level(limit, f"y{suffix}") for limit in limits]
        titles.append(strip_title(_titled(name, label, limits), domain[1]))
        rows.append(summary(words(name), trace, factor, label))
    bottom = f"y{len(found)}" if len(found) > 1 else "y"
    axes["xaxis"] = axis(f"time [{clock}]", range=[per_second * end for end in span(diagnosis)], anchor=bottom)
    return Figure(
        name="decisions",
        title="What was decided on",
        caption="What the stopping rules compare, over time. Dashed: thresholds. Red: beyond one, an alarm.",
        alternative=f"{', '.join(map(words, found))} over time, with thresholds; ranges in the table beneath.",
        data=data,
        layout=layout(height, hovermode="x", showlegend=False, shapes=shapes, annotations=titles, **axes),
        height=height,
        summary=rows,
        timed=True,
    )


def _titled(name: str, label: str, limits: list[float]) -> str:
    told = ", ".join(number(limit, 3) for limit in limits)
    return bracketed(words(name), label) + (f", alarm from {told}" if told else "")


def _strip(
    trace: Trace, per_second: float, factor: float, label: str, levels: tuple[float, ...], axis_name: str
) -> list[dict[str, Any]]:
    """The statistic, and a red mark over every bin that is beyond one of the levels."""
    lower, upper = np.asarray(trace.lower, float), np.asarray(trace.upper, float)
    beyond = np.zeros(len(upper), bool)
    for level in levels:
        beyond |= (upper >= level) if level > 0.0 else (lower <= level)
    drawn = strip(trace, per_second, factor, label, axis_name)
    if beyond.any():
        extreme = factor * np.where(beyond, np.where(np.abs(upper) >= np.abs(lower), upper, lower), np.nan)
        marks = {"mode": "markers", "marker": {"color": RED, "size": 4}, "hoverinfo": "skip", "yaxis": axis_name}
        marks |= drawn_as("beyond", trace, per_second, factor, limits=list(levels))
        drawn.append(line(centres(trace, per_second), extreme, RED, "alarm", **marks))
    return drawn


def _level(value: float, axis_name: str) -> dict[str, Any]:
    looks = {"color": RED, "width": 1.2, "dash": "dash"}
    return {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "yref": axis_name, "y0": value, "y1": value} | {
        "line": looks
    }


def design_figures(diagnosis: Diagnosis) -> list[Figure]:
    """One chart for every rule that was designed; rules of one design share one."""
    drawn: dict[Any, list[Decided]] = {}
    for each in diagnosis.decisions:
        if each.curve is not None and each.curve.along:
            drawn.setdefault(each.curve, []).append(each)
    return [_design(index, group) for index, group in enumerate(drawn.values())]


def _design(index: int, group: list[Decided]) -> Figure:
    curve = group[0].curve
    assert curve is not None
    name = "; ".join(each.name for each in group)
    kind: dict[str, Any] = {} if curve.chance else {"type": "log"}
    data = [line(np.asarray(curve.along), np.asarray(curve.up), BLUE, "design")]
    if curve.chosen is not None:
        place = {"x": rounded([curve.chosen[0]]), "y": rounded([curve.chosen[1]])}
        looks = {"mode": "markers", "marker": {"color": RED, "size": 9}, "name": "in effect"}
        data.append({"type": "scatter"} | place | looks)
    told = "How often a change of that size is found at one look" if curve.chance else DELAY
    guide = {"color": GREY, "width": 1, "dash": "dot"}
    shapes = [
        {"type": "line", "yref": "paper", "y0": 0, "y1": 1, "x0": curve.chosen[0], "x1": curve.chosen[0], "line": guide}
        for _ in (1,)
        if curve.chosen is not None and curve.chance
    ]
    return Figure(
        name=f"design-{index}",
        title=f"Rule of: {name}",
        caption=f"{told}. Red: in effect; {group[0].false_alarms}.",
        alternative=f"{curve.up_title} over {curve.along_title}.",
        data=data,
        layout=layout(
            _PANEL,
            showlegend=False,
            shapes=shapes,
            xaxis=axis(curve.along_title, **kind),
            yaxis=axis(curve.up_title, **kind),
        ),
        height=_PANEL,
    )
