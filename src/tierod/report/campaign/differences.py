"""The chart of a comparison: the difference of every pair, with mean and interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tierod.core.shown import shown
from tierod.report.campaign.words import TITLES, amount, value
from tierod.report.charts.figure import BLUE, GREY, RED, Figure, axis, layout, rounded, strip_title
from tierod.report.display import bracketed

_SHOWN = ("detection_s", "bias", "absolute_bias", "deviation")
"""Figures whose differences are drawn."""


def difference_figure(index: int, figures: Sequence[Mapping[str, Any]]) -> Figure | None:
    """Differences of every pair, with mean and interval."""
    drawn = [figure for figure in figures if figure["name"] in _SHOWN and figure["pairs"]]
    if not drawn:
        return None
    height = 60 + 110 * len(drawn)
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    notes, shapes, rows = [], [], []
    for at, figure in enumerate(drawn):
        suffix = "" if at == 0 else str(at + 1)
        domain = [1.0 - (at + 1) / len(drawn) + 46.0 / height, 1.0 - at / len(drawn) - 24.0 / height]
        factor, label = shown(figure["unit"])
        axes[f"xaxis{suffix}"] = axis("", anchor=f"y{suffix}", zeroline=False)
        axes[f"yaxis{suffix}"] = axis("", domain=domain, anchor=f"x{suffix}", range=[-1, 1], visible=False)
        data += _dots(figure, factor, suffix)
        line = {"color": RED, "width": 1.2, "dash": "dash"}
        where = {"xref": f"x{suffix}", "yref": f"y{suffix} domain", "x0": 0, "x1": 0, "y0": 0, "y1": 1}
        shapes.append({"type": "line", "line": line} | where)
        notes.append(strip_title(bracketed(TITLES[figure["name"]].capitalize(), label), domain[1]))
        mean, median = (amount(value(figure[key]), figure["unit"]) for key in ("mean", "median"))
        rows.append((TITLES[figure["name"]].capitalize(), mean, median, str(figure["pairs"])))
    return Figure(
        name=f"differences-{index}",
        title="Differences of pairs",
        caption="The second campaign less the first: a grey dot per drive, mean and its 95 % interval in blue. Left of "
        "the dashed line the second one has less.",
        alternative="Differences of every pair for several figures; means in the table beneath.",
        data=data,
        layout=layout(height, showlegend=False, annotations=notes, shapes=shapes, **axes),
        height=height,
        summary=rows,
        columns=("figure", "mean", "median", "pairs"),
    )


def _dots(figure: Mapping[str, Any], factor: float, suffix: str) -> list[dict[str, Any]]:
    differences = np.asarray(figure["differences"], float) * factor
    # Spread evenly across the strip, always alike.
    across = 0.7 * (((np.arange(len(differences)) * 0.6180339887) % 1.0) - 0.5)
    low, high = (value(end) * factor for end in figure["interval"])
    mean = value(figure["mean"]) * factor
    places = {"type": "scatter", "mode": "markers", "xaxis": f"x{suffix}", "yaxis": f"y{suffix}"}
    spread = {"type": "data", "symmetric": False, "array": [high - mean], "arrayminus": [mean - low], "color": BLUE}
    dots = {"x": rounded(differences), "y": rounded(across), "marker": {"color": GREY, "size": 6, "opacity": 0.6}}
    middle = {"x": [mean], "y": [0.75], "marker": {"color": BLUE, "size": 10, "symbol": "diamond"}}
    return [
        places | dots | {"hovertemplate": "%{x:.4g}<extra></extra>"},
        places | middle | {"error_x": spread | {"thickness": 2.5}, "hovertemplate": "mean %{x:.4g}<extra></extra>"},
    ]
