"""Histograms of the estimate, one strip per stretch of the drive."""

from __future__ import annotations

from typing import Any

import numpy as np

from tierod.core.findings import Diagnosis
from tierod.core.shown import shown
from tierod.report.charts.figure import BLUE, Figure, axis, layout, level_colour, references, rounded, strip_title
from tierod.report.display import bracketed, number, words


def histogram_figure(diagnosis: Diagnosis) -> Figure | None:
    """The histograms above each other on a common axis; None where there is none."""
    if not diagnosis.histograms:
        return None
    estimate = diagnosis.findings[0].estimate if diagnosis.findings else None
    factor, label = shown(estimate.unit if estimate else "")
    count = len(diagnosis.histograms)
    height = 60 + max(70, min(110, 900 // count)) * count
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    titles, rows = [], []
    for index, (name, (edges, counts)) in enumerate(diagnosis.histograms.items()):
        edges, counts = np.asarray(edges, float) * factor, np.asarray(counts, float)
        suffix = "" if index == 0 else str(index + 1)
        domain = [1.0 - (index + 1) / count, 1.0 - index / count - 24.0 / height]
        axes[f"yaxis{suffix}"] = axis("", domain=domain, nticks=3, rangemode="tozero", tickformat=".0%")
        data.append(_bars(words(name), edges, counts, f"y{suffix}", label))
        titles.append(strip_title(words(name), domain[1]))
        rows.append((words(name), *_figures(edges, counts, label)))
    levels = references(diagnosis, estimate.unit) if estimate else []
    axes["xaxis"] = axis(bracketed("estimate", label), anchor=f"y{count}" if count > 1 else "y")
    return Figure(
        name="histograms",
        title="Stretch by stretch",
        caption="How the estimate was spread in each stretch of the drive (share of its samples). "
        "Dashed: what it is judged against.",
        alternative="Histograms of the estimate for each stretch; medians and spreads in the table beneath.",
        data=data,
        layout=layout(
            height, showlegend=False, bargap=0.05, shapes=[_level(*each) for each in levels], annotations=titles, **axes
        ),
        height=height,
        summary=rows,
        columns=("stretch", "5 % below", "median", "95 % below"),
    )


def _bars(name: str, edges: np.ndarray, counts: np.ndarray, axis_name: str, label: str) -> dict[str, Any]:
    total = counts.sum()
    return {
        "type": "bar",
        "name": name,
        "x": rounded(0.5 * (edges[:-1] + edges[1:])),
        "y": rounded(counts / total if total > 0.0 else counts),
        "width": rounded(np.diff(edges)),
        "marker": {"color": BLUE},
        "yaxis": axis_name,
        "hovertemplate": "%{x:.4g} " + label + ": %{y:.1%}<extra>" + name + "</extra>",
    }


def _figures(edges: np.ndarray, counts: np.ndarray, label: str) -> tuple[str, str, str]:
    total = counts.sum()
    if not total > 0.0:
        return "–", "–", "–"
    shares = np.concatenate(([0.0], np.cumsum(counts) / total))
    low, middle, high = (
        f"{number(float(np.interp(at, shares, edges)), 3)} {label}".strip() for at in (0.05, 0.5, 0.95)
    )
    return low, middle, high


def _level(name: str, value: float) -> dict[str, Any]:
    looks = {"color": level_colour(name), "width": 1.3, "dash": "dash"}
    return {"type": "line", "yref": "paper", "y0": 0, "y1": 1, "x0": value, "x1": value, "line": looks}
