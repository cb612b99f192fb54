"""The main chart of a diagnosis as a plotly figure, for notebooks and scripts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tierod.core.errors import InputError
from tierod.core.findings import Diagnosis
from tierod.report.charts.distributions import histogram_figure, loop_figure
from tierod.report.charts.figure import Figure
from tierod.report.charts.over_time import estimate_figures, innovation_figure, signal_figure

if TYPE_CHECKING:
    import plotly.graph_objects

CHARTS = ("estimate", "hysteresis", "stretches", "consistency", "drive")


def plot(diagnosis: Diagnosis, chart: str = "estimate") -> plotly.graph_objects.Figure:
    """One chart of the report.

    Args:
        diagnosis: what was found
        chart: "estimate" over time, "hysteresis", "stretches" (histograms), "consistency" or "drive" (the signals)

    Raises:
        InputError: no such chart, or the diagnosis has nothing to show in it
    """
    import plotly.graph_objects

    if chart not in CHARTS:
        raise InputError(f"there is no chart '{chart}'; choose one of {', '.join(CHARTS)}")
    figure = _figure(diagnosis, chart)
    if figure is None:
        raise InputError(f"this diagnosis has nothing to show as '{chart}'; choose another of {', '.join(CHARTS)}")
    return plotly.graph_objects.Figure({"data": figure.data, "layout": figure.layout})


def _figure(diagnosis: Diagnosis, chart: str) -> Figure | None:
    if chart == "estimate":
        return next(iter(estimate_figures(diagnosis)), None)
    makers = {
        "hysteresis": loop_figure,
        "stretches": histogram_figure,
        "consistency": innovation_figure,
        "drive": signal_figure,
    }
    return makers[chart](diagnosis)
