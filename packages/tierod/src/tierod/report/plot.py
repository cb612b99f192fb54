"""The main chart of a diagnosis as a plotly figure, for notebooks and scripts."""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING, Any

from tierod.core.errors import InputError
from tierod.core.findings import Diagnosis
from tierod.report.charts.decisions import histogram_chart, loop_chart
from tierod.report.charts.figure import Figure
from tierod.report.charts.over_time import estimate_figures, innovation_figure, signal_figure
from tierod.report.charts.panels import panel_figure
from tierod.report.html import TEMPLATES

if TYPE_CHECKING:
    import plotly.graph_objects

CHARTS = ("estimate", "hysteresis", "stretches", "consistency", "drive")


def plot(diagnosis: Diagnosis, chart: str = "estimate") -> plotly.graph_objects.Figure:
    """One chart of the report as a plotly figure."""
    import plotly.graph_objects

    if chart not in CHARTS:
        raise InputError(f"there is no chart '{chart}'; choose one of {', '.join(CHARTS)}")
    figure = _figure(diagnosis, chart)
    if figure is None:
        raise InputError(f"this diagnosis has nothing to show as '{chart}'; choose another of {', '.join(CHARTS)}")
    return plotly.graph_objects.Figure(_coloured({"data": figure.data, "layout": figure.layout}))


def _coloured(value: Any) -> Any:
    if isinstance(value, str):
        return _colours().get(value, value)
    if isinstance(value, dict):
        return {key: _coloured(each) for key, each in value.items()}
    return [_coloured(each) for each in value] if isinstance(value, list) else value


@cache
def _colours() -> dict[str, str]:
    style = (TEMPLATES / "tokens.css").read_text(encoding="utf-8")
    found = re.findall(r"(--[a-z-]+): var\(--light, (#\w+|rgba\([^)]*\))\)", style)
    return {f"var({name})": colour for name, colour in found}


def _figure(diagnosis: Diagnosis, chart: str) -> Figure | None:
    match chart:
        case "estimate":
            return next(iter(estimate_figures(diagnosis)), None)
        case "consistency":
            return innovation_figure(diagnosis)
        case "drive":
            return signal_figure(diagnosis)
    found = loop_chart(diagnosis) if chart == "hysteresis" else histogram_chart(diagnosis)
    return panel_figure(found) if found else None
