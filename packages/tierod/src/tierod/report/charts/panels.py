"""Charts of panels, translated from their plain description to plotly."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tierod.core.content import Band, Bars, Boxes, Cells, Chart, Lines, Mark, Panel, Points
from tierod.core.decimation import outline
from tierod.report.charts.figure import (
    AMBER,
    BLUE,
    GREEN,
    GREY,
    LABEL_GROUND,
    RED,
    TEXT,
    Figure,
    Summary,
    across,
    axis,
    band,
    layout,
    level_colour,
    rounded,
    strip_title,
    upright,
)
from tierod.report.display import number

_COLOURS = (BLUE, RED, GREEN, AMBER, "var(--violet)", "var(--cyan)", GREY, "var(--pink)")
_PANEL, _ALONE = 240, 330
_BESIDE = 0.65  # Space above and below the outermost named rows [row heights]
_MOST = 1600  # Largest number of points of a curve: lowest and highest value per pixel column of the widest chart
# Digits of a curve relative to its largest value; more on a logarithmic axis, where small values are visible
_DIGITS, _SMALL = 5, 10


def panel_figure(chart: Chart) -> Figure:
    """A chart with its panels above each other, as plotly draws it."""
    count = len(chart.panels)
    height = max((_ALONE if count == 1 else _PANEL * count) + 110, *(_rows(panel) for panel in chart.panels))
    colours = _colours(chart)
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    named_marks: set[str] = set()
    for index, panel in enumerate(chart.panels):
        suffix = "" if index == 0 else str(index + 1)
        top, gap = 1.0 - index / count, 78.0 / height
        domain = [1.0 - (index + 1) / count + (gap if index + 1 < count else 0.0), top - (24.0 / height) * (count > 1)]
        axes |= _axes(panel, suffix, domain)
        if chart.shared_axes and index:
            axes[f"xaxis{suffix}"] |= {"matches": "x"}
            axes[f"yaxis{suffix}"] |= {"matches": "y"}
        for mark in panel.marks:
            named_beside = mark.name in [name for name, _ in panel.rows]
            shown = {"showlegend": mark.name not in named_marks and not named_beside, "legendgroup": mark.name}
            named_marks.add(mark.name)
            drawn_mark = _drawn(mark, colours[mark.name], panel)
            drawn_mark = _turned(drawn_mark) if panel.sideways else drawn_mark
            data.append(drawn_mark | shown | {"xaxis": f"x{suffix}", "yaxis": f"y{suffix}"})
        drawn, named = _rules(replace(panel, levels=(), uprights=panel.levels) if panel.sideways else panel, suffix)
        shapes += drawn
        notes += named
        notes += [strip_title(panel.title, domain[1])] if count > 1 or chart.shared_axes else []
    return Figure(
        name=chart.name,
        title=chart.title,
        caption=chart.caption,
        alternative=chart.alternative,
        data=data,
        layout=layout(height, barmode="overlay", boxmode="group", bargap=0.0, shapes=shapes, annotations=notes, **axes),
        height=height,
        columns=chart.columns,
        summary=_summaries(chart) if chart.summary is None else chart.summary,
    )


def _rows(panel: Panel) -> int:
    """Height that a sideways panel, named rows or cells need [pixels]; 0 for any other panel."""
    most = len({name for mark in panel.marks if isinstance(mark, Points) for name in mark.x})
    rows = max((len(mark.down) for mark in panel.marks if isinstance(mark, Cells)), default=0)
    if panel.rows:
        return 130 + 22 * len(panel.rows)
    return 150 + 22 * most if panel.sideways else 230 + 26 * rows if rows else 0


def _axes(panel: Panel, suffix: str, domain: list[float]) -> dict[str, Any]:
    along, up = axis(panel.x_title, anchor=f"y{suffix}", automargin=True), axis(panel.y_title)
    if panel.sideways:
        along, up = axis(panel.y_title, anchor=f"y{suffix}"), axis("", autorange="reversed", automargin=True)
    if any(isinstance(mark, Cells) for mark in panel.marks):
        up |= {"autorange": "reversed", "automargin": True}
    if panel.rows:
        heights = [height for _, height in panel.rows]
        up |= {"tickvals": heights, "ticktext": [name for name, _ in panel.rows], "automargin": True, "zeroline": False}
        up |= {"range": [min(heights) - _BESIDE, max(heights) + _BESIDE]}
    if panel.to_scale:
        up |= {"scaleanchor": f"x{suffix}"}
        along |= {"constrain": "domain"}
    kind: dict[str, Any] = {"type": "log"} if panel.logarithmic else {}
    along |= {"type": "log", "dtick": 1, "minor": {"showgrid": True}} if panel.logarithmic_along else {}
    return {f"xaxis{suffix}": along, f"yaxis{suffix}": up | {"domain": domain, "anchor": f"x{suffix}"} | kind}


def _colours(chart: Chart) -> dict[str, str]:
    names = dict.fromkeys(mark.name for panel in chart.panels for mark in panel.marks)
    return {name: _COLOURS[index % len(_COLOURS)] for index, name in enumerate(names)}


def _turned(mark: dict[str, Any]) -> dict[str, Any]:
    """A mark with horizontal and vertical axis swapped, including its error bars."""
    turned = mark | {"x": mark["y"], "y": mark["x"]}
    return turned | {"error_x": turned.pop("error_y")} if "error_y" in turned else turned


def _outlined(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A long curve thinned to the resolution of the chart; a loop, whose x values are not ascending, unchanged."""
    if len(y) <= _MOST or not np.all(np.diff(x) >= 0.0):
        return x, y
    kept = outline(y, _MOST)
    return x[kept], y[kept]


def _drawn(mark: Mark, colour: str, panel: Panel) -> dict[str, Any]:
    match mark:
        case Lines():
            line = {"color": colour, "width": 1.5, "dash": "dash" if mark.dashed else "solid"}
            along, up = _SMALL if panel.logarithmic_along else 6, _SMALL if panel.logarithmic else _DIGITS
            x, y = _outlined(np.asarray(mark.x, float), np.asarray(mark.y, float))
            points = {"x": rounded(x, along), "y": rounded(y, up), "connectgaps": False}
            return {"type": "scatter", "mode": "lines", "name": mark.name, "line": line} | points
        case Bars():
            edges = np.asarray(mark.edges, float)
            places = {"x": rounded(0.5 * (edges[1:] + edges[:-1])), "width": rounded(np.diff(edges))}
            looks = {"marker": {"color": colour}, "opacity": 0.55}
            return {"type": "bar", "name": mark.name, "y": rounded(mark.shares)} | places | looks
        case Points():
            return _points(mark, colour)
        case Band():
            x, low, high = (np.asarray(values, float) for values in (mark.x, mark.low, mark.high))
            return band(x, low, high, colour, name=mark.name, opacity=0.25, line={"width": 0})
        case Boxes():
            ends = {"q1": mark.lower, "median": mark.median, "q3": mark.upper, "lowerfence": mark.low}
            values = {key: rounded(value) for key, value in (ends | {"upperfence": mark.high}).items()}
            looks = {"line": {"color": colour, "width": 1.5}, "name": mark.name}
            return {"type": "box", "x": list(mark.places)} | values | looks
        case Cells():
            return _cells(mark, colour)


def _cells(mark: Cells, colour: str) -> dict[str, Any]:
    """Heat map in which darker means more; the cell also shows the value, so that nothing depends on colour only."""
    shares = np.asarray(mark.shares, float)
    return {
        "type": "heatmap",
        "name": mark.name,
        "x": list(mark.across),
        "y": list(mark.down),
        "z": [rounded(row) for row in shares],
        "text": [[number(value, 2) if value > 0.0 else "" for value in row] for row in shares],
        "texttemplate": "%{text}",
        "zmin": 0.0,
        "zmax": 1.0,
        "colorscale": [[0.0, "var(--ground)"], [1.0, colour]],
        "showscale": False,
        "xgap": 1,
        "ygap": 1,
    }


def _points(mark: Points, colour: str) -> dict[str, Any]:
    places = list(mark.x) if any(isinstance(x, str) for x in mark.x) else rounded(np.asarray(mark.x, float))
    drawn: dict[str, Any] = {
        "type": "scatter",
        "mode": "markers",
        "name": mark.name,
        "x": places,
        "y": rounded(mark.y),
        "marker": {"color": colour, "size": 8},
    }
    if mark.low is not None and mark.high is not None:
        y, low, high = (np.asarray(values, float) for values in (mark.y, mark.low, mark.high))
        spread = {"array": rounded(high - y), "arrayminus": rounded(y - low)}
        drawn["error_y"] = {"type": "data", "symmetric": False, "color": colour, "thickness": 1.5} | spread
    return drawn


def _rules(panel: Panel, suffix: str) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    text = {"showarrow": False, "font": {"size": 12, "color": TEXT}, "bgcolor": LABEL_GROUND, "borderpad": 1}
    x_domain, y_domain = f"x{suffix} domain", f"y{suffix} domain"
    # Plotly takes positions on a logarithmic axis as values for shapes, but as exponents for annotations.
    shapes, notes = [], []
    for name, level in panel.levels:
        shapes.append(across(level, _rule_colour(name), 1.2, xref=x_domain, yref=f"y{suffix}"))
        at = float(np.log10(level)) if panel.logarithmic else level
        place = {"xref": x_domain, "x": 1, "xanchor": "right", "yref": f"y{suffix}", "y": at, "yanchor": "bottom"}
        notes.append(text | place | {"text": name})
    for row, (name, place_along) in enumerate(panel.uprights):
        along = float(np.log10(place_along)) if panel.logarithmic_along else place_along
        shapes.append(upright(place_along, _rule_colour(name), 1.2, xref=f"x{suffix}", yref=y_domain))
        place = {"xref": f"x{suffix}", "x": along, "xanchor": "left", "yref": y_domain, "y": 1, "yanchor": "top"}
        notes.append(text | place | {"text": name, "xshift": 3, "yshift": -14 * (row % 3)})
    return shapes, notes


def _rule_colour(name: str) -> str:
    """Colour of a reference level such as "fault", as in other charts; that of the text for any other rule."""
    return TEXT if (colour := level_colour(name)) == GREY else colour


def _summaries(chart: Chart) -> list[Summary]:
    return [_summary(panel, mark, len(chart.panels)) for panel in chart.panels for mark in panel.marks]


def _summary(panel: Panel, mark: Mark, count: int) -> Summary:
    """Lowest, mean and highest value of a mark for the table; for a histogram the range and mean of its values."""
    name = f"{panel.title}: {mark.name}" if count > 1 and panel.title else mark.name
    if isinstance(mark, Bars):
        edges, shares = np.asarray(mark.edges, float), np.asarray(mark.shares, float)
        held = shares > 0.0
        if not held.any():
            return name, "–", "–", "–"
        mean = float(np.sum(0.5 * (edges[1:] + edges[:-1]) * shares) / np.sum(shares))
        return name, number(float(edges[:-1][held][0]), 4), number(mean, 4), number(float(edges[1:][held][-1]), 4)
    if isinstance(mark, Band):
        low, high = (np.asarray(ends, float) for ends in (mark.low, mark.high))
        return f"{name}, band", *_three(low, 0.5 * (low + high), high)
    values = np.asarray(_heights(mark), float)
    return name, *_three(values, values, values)


def _heights(mark: Lines | Points | Boxes | Cells) -> Any:
    match mark:
        case Boxes():
            return mark.median
        case Cells():
            return mark.shares
    return mark.y


def _three(low: np.ndarray, middle: np.ndarray, high: np.ndarray) -> tuple[str, str, str]:
    """Lowest of the first, mean of the second, highest of the third; dashes without finite values."""
    if not np.isfinite(middle).any():
        return "–", "–", "–"
    return number(float(np.nanmin(low)), 4), number(float(np.nanmean(middle)), 4), number(float(np.nanmax(high)), 4)
