"""Charts of sensors and actuators: their states over time, and the substitutes of faulty sensors."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from tierod.core.decimation import merged
from tierod.core.findings import Diagnosis, Element, Episode
from tierod.core.shown import shown
from tierod.core.statuses import Status
from tierod.report.charts.figure import (
    AMBER,
    BLUE,
    LABEL_GROUND,
    RED,
    Figure,
    axis,
    band,
    centres,
    drawn_as,
    layout,
    line,
    rounded,
    summary,
)
from tierod.report.charts.over_time import span
from tierod.report.display import INTERVAL, bracketed, instant, time_scale, words

# Prefixes of the names of the traces drawn here
STATE, SUPPLIED, DEVIATION = "state_of_", "supplied_", "deviation_of_supplied_"
WASH = 0.1  # Opacity of the shading of fault episodes
_POINTS = 1000
# Values of a state, their statuses and colours; blank where nothing was judged
_HEATS = (
    (0.0, Status.HEALTHY, "var(--state-good)"),
    (0.25, Status.NOT_TESTABLE, "var(--state-open)"),
    (0.5, Status.SUSPECT, "var(--state-doubt)"),
    (1.0, Status.FAULT, RED),
)
OTHERWISE = "not judged"


def state_figure(diagnosis: Diagnosis) -> Figure | None:
    """Coloured row over time for every sensor and actuator."""
    names = [each.name for each in diagnosis.elements if STATE + each.name in diagnosis.traces]
    if not names:
        return None
    per_second, clock = time_scale(span(diagnosis)[1] - span(diagnosis)[0])
    traces = [merged(diagnosis.traces[STATE + name], _POINTS) for name in names]
    worst = [np.asarray(trace.upper, float) for trace in traces]
    meanings = {value: str(status) for value, status, _ in _HEATS}
    text = [[meanings.get(value, OTHERWISE) for value in row.tolist()] for row in worst]
    height = 26 * len(names) + 120
    heat = {
        "type": "heatmap",
        "x": rounded(centres(traces[0], per_second), 7),
        "y": [words(name) for name in names],
        "z": [rounded(row) for row in worst],
        "text": text,
        "hovertemplate": "%{y}: %{text}<extra>%{x}</extra>",
        "meta": {
            "rows": [trace.name for trace in traces],
            "part": "rows",
            "per_second": per_second,
            "meanings": [[value, meaning] for value, meaning in meanings.items()],
            "otherwise": OTHERWISE,
        },
        "colorscale": _steps(),
        "zmin": 0.0,
        "zmax": 1.0,
        "ygap": 3,
        "showscale": False,
    }
    # Traces without points provide the legend, which a heatmap lacks.
    keys = [
        {
            "type": "scatter",
            "mode": "markers",
            "x": [None],
            "y": [None],
            "name": str(status),
            "marker": {"symbol": "square", "size": 12, "color": colour},
        }
        for _, status, colour in _HEATS
    ]
    faulty = [words(each.name).lower() for each in diagnosis.elements if each.episodes]
    return Figure(
        name="states",
        title="Sensors and actuators over time",
        caption="The worst state of each moment. Blank: nothing could be judged.",
        alternative=f"States over time of {', '.join(words(name).lower() for name in names)}; "
        f"faulty at times: {', '.join(faulty) or 'none'}. The table above lists the times.",
        data=[heat, *keys],
        layout=layout(
            height,
            margin={"l": 190, "r": 14, "t": 44, "b": 44},
            xaxis=axis(f"time [{clock}]", range=[per_second * end for end in span(diagnosis)]),
            yaxis=axis("", autorange="reversed", showgrid=False),
        ),
        height=height,
        timed=True,
    )


def _steps() -> list[list[Any]]:
    values = [value for value, _, _ in _HEATS]
    edges = [0.0, *(0.5 * (low + high) for low, high in pairwise(values)), 1.0]
    return [[edge, colour] for (_, _, colour), ends in zip(_HEATS, pairwise(edges), strict=True) for edge in ends]


def substitute_figures(diagnosis: Diagnosis) -> list[Figure]:
    """One chart per replaced faulty sensor: its reading, and the supplied value."""
    return [
        _substitute(diagnosis, each)
        for each in diagnosis.elements
        if each.episodes and each.name in diagnosis.traces and SUPPLIED + each.name in diagnosis.traces
    ]


def _substitute(diagnosis: Diagnosis, element: Element) -> Figure:
    name = element.name
    reading, value, deviation = (merged(diagnosis.traces[each + name]) for each in ("", SUPPLIED, DEVIATION))
    factor, label = shown(value.unit)
    first, last = span(diagnosis)
    per_second, clock = time_scale(last - first)
    time = centres(value, per_second)
    supplied = np.asarray(value.mean, float) * factor
    half = INTERVAL * factor * np.asarray(deviation.mean, float)
    text = {"hovertemplate": "%{y:.4g} " + label}
    marks = [_marks(each, first, last, per_second) for each in element.episodes]
    what = element.substitute or "another signal"
    apart = drawn_as("interval", value, per_second, factor, deviation=deviation.name, deviations=INTERVAL)
    read, given = (text | drawn_as("mean", trace, per_second, factor) for trace in (reading, value))
    return Figure(
        name=f"substitute-{name}",
        title=f"{words(name)}: its reading, and what replaced it",
        caption=f"Red: as recorded. Blue: as supplied to other functions, with its 95 % interval where it is "
        f"replaced, mostly by {what}. Shaded: at fault.",
        alternative=f"{words(name)} as recorded and as replaced by {what}; at fault "
        + "; ".join(f"from {instant(each.start)} to {_end(each)}" for each in element.episodes)
        + ".",
        data=[
            band(time, supplied - half, supplied + half, BLUE, opacity=0.25, name="95 % interval", **apart),
            line(centres(reading, per_second), np.asarray(reading.mean, float) * factor, RED, "reading", **read),
            line(time, supplied, BLUE, "supplied", **given),
        ],
        layout=layout(
            330,
            hovermode="x unified",
            xaxis=axis(f"time [{clock}]", range=[per_second * first, per_second * last]),
            yaxis=axis(bracketed(words(name), label)),
            shapes=[shape for shape, _ in marks],
            annotations=[note for _, note in marks],
        ),
        height=330,
        summary=[
            summary("reading", reading, factor, label),
            summary("supplied", value, factor, label),
            summary("standard deviation of the replacement", deviation, factor, label),
        ],
        timed=True,
    )


def _marks(episode: Episode, first: float, last: float, per_second: float) -> tuple[dict[str, Any], dict[str, Any]]:
    start, end = (per_second * at for at in (episode.start, last if episode.end is None else episode.end))
    shape = {"type": "rect", "yref": "paper", "y0": 0, "y1": 1, "x0": start, "x1": end, "line": {"width": 0}}
    colour = AMBER if episode.candidates else RED
    note = {
        "text": "in doubt" if episode.candidates else episode.kind or "fault",
        "x": start,
        "yref": "paper",
        "y": 1.0,
    }
    late = start > per_second * (first + 0.85 * (last - first))
    looks = {"xanchor": "right" if late else "left", "yanchor": "top", "showarrow": False, "bgcolor": LABEL_GROUND}
    return (
        shape | {"fillcolor": colour, "opacity": WASH, "layer": "below"},
        note | looks | {"font": {"color": colour, "size": 12}},
    )


def _end(episode: Episode) -> str:
    return "the end" if episode.end is None else instant(episode.end)
