"""Histograms of the estimate for stretches of the drive, and loops of torque over steering wheel angle."""

from __future__ import annotations

from typing import Any

import numpy as np

from tierod.core.findings import Diagnosis
from tierod.core.shown import shown
from tierod.report.charts.figure import (
    BLUE,
    Figure,
    axis,
    layout,
    level_colour,
    references,
    rounded,
    strip_title,
    upright,
)
from tierod.report.display import bracketed, number, words


def histogram_figure(diagnosis: Diagnosis) -> Figure | None:
    """Histograms above each other on a common axis; None without histograms."""
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
    lines = [upright(value, level_colour(name), 1.3) for name, value in levels]
    axes["xaxis"] = axis(bracketed("estimate", label), anchor=f"y{count}" if count > 1 else "y")
    return Figure(
        name="histograms",
        title="Stretch by stretch",
        caption="Distribution of the estimate in each stretch of the drive (share of its samples). Dashed: its "
        "reference levels.",
        alternative="Histograms of the estimate for each stretch; medians and spreads in the table beneath.",
        data=data,
        layout=layout(height, showlegend=False, bargap=0.05, shapes=lines, annotations=titles, **axes),
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


_PANEL = 250


def loop_figure(diagnosis: Diagnosis) -> Figure | None:
    """Hysteresis loops above each other on common scales; None without loops."""
    if not diagnosis.loops:
        return None
    _, torque_label = shown(str(diagnosis.vehicle.get("torque_unit", "N*m")))
    to_degrees, angle_label = shown("rad")
    count = len(diagnosis.loops)
    height = 70 + _PANEL * count
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    titles, rows = [], []
    for index, (name, (angle, torque)) in enumerate(diagnosis.loops.items()):
        angle, torque = np.asarray(angle, float) * to_degrees, np.asarray(torque, float)
        suffix = "" if index == 0 else str(index + 1)
        domain = [1.0 - (index + 1) / count, 1.0 - index / count - 26.0 / height]
        same_scale = {"matches": "y"} if index else {}
        axes[f"yaxis{suffix}"] = axis(bracketed("torque", torque_label), domain=domain, **same_scale)
        data.append(_loop(words(name), angle, torque, f"y{suffix}", torque_label))
        titles.append(strip_title(words(name), domain[1]))
        width = _half_height(angle, torque, torque_label)
        rows.append((words(name), _range(angle, angle_label), _range(torque, torque_label), width))
    axes["xaxis"] = axis(bracketed("steering wheel angle", angle_label), anchor=f"y{count}" if count > 1 else "y")
    return Figure(
        name="loops",
        title="Hysteresis",
        caption="Steering torque over steering wheel angle. Friction opens the loop: half its height in the middle is "
        "about the friction. A closed line means that there was no friction, or that the stroke was too small to "
        "show it.",
        alternative=f"Torque over angle for {', '.join(map(words, diagnosis.loops))}; sizes in the table beneath.",
        data=data,
        layout=layout(height, showlegend=False, annotations=titles, **axes),
        height=height,
        summary=rows,
        columns=("loop", "angle", "torque", "half height in the middle"),
    )


def _loop(name: str, angle: np.ndarray, torque: np.ndarray, axis_name: str, label: str) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": rounded(angle),
        "y": rounded(torque),
        "yaxis": axis_name,
        "line": {"color": BLUE, "width": 1.0},
        "opacity": 0.7,
        "hovertemplate": "%{x:.4g}°, %{y:.4g} " + label + f"<extra>{name}</extra>",
    }


def _range(values: np.ndarray, label: str) -> str:
    seen = values[np.isfinite(values)]
    return f"{number(float(seen.min()), 3)} to {number(float(seen.max()), 3)} {label}" if len(seen) else "–"


def _half_height(angle: np.ndarray, torque: np.ndarray, label: str) -> str:
    """Half the vertical distance between increasing and decreasing angle, in the middle third of the angle range."""
    step = np.gradient(angle) if len(angle) > 1 else np.zeros(len(angle))
    low, high = (np.nanmin(angle), np.nanmax(angle)) if np.isfinite(angle).any() else (0.0, 0.0)
    middle = np.abs(angle - 0.5 * (low + high)) <= (high - low) / 6.0
    there, back = torque[middle & (step > 0.0)], torque[middle & (step < 0.0)]
    if not np.isfinite(there).any() or not np.isfinite(back).any():
        return "–"
    return f"{number(0.5 * float(np.nanmedian(there) - np.nanmedian(back)), 3)} {label}"
