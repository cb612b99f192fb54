"""Histograms of the estimate for stretches of the drive, and loops of torque over steering wheel angle."""

from __future__ import annotations

import numpy as np

from tierod.core.content import Bars, Chart, Lines, Panel
from tierod.core.findings import Diagnosis
from tierod.core.shown import shown
from tierod.report.charts.figure import references
from tierod.report.display import bracketed, number, words


def histogram_chart(diagnosis: Diagnosis) -> Chart | None:
    """Histograms above each other on a common axis; None without histograms."""
    if not diagnosis.histograms:
        return None
    estimate = diagnosis.findings[0].estimate if diagnosis.findings else None
    factor, label = shown(estimate.unit if estimate else "")
    levels = tuple(references(diagnosis, estimate.unit)) if estimate else ()
    panels, rows = [], []
    for name, (edges, counts) in diagnosis.histograms.items():
        edges, counts = np.asarray(edges, float) * factor, np.asarray(counts, float)
        shares = counts / counts.sum() if counts.sum() > 0.0 else counts
        marks = (Bars("share", edges, shares),)
        panels.append(Panel(words(name), bracketed("estimate", label), "share", marks, uprights=levels))
        rows.append((words(name), *_quantiles(edges, shares, label)))
    return Chart(
        "histograms",
        "Stretch by stretch",
        "Distribution of the estimate in each stretch of the drive (share of its samples). Dashed: its reference "
        "levels.",
        "Histograms of the estimate for each stretch; medians and spreads in the table beneath.",
        tuple(panels),
        ("stretch", "5 % below", "median", "95 % below"),
        tuple(rows),
        shared_axes=True,
    )


def _quantiles(edges: np.ndarray, shares: np.ndarray, label: str) -> tuple[str, ...]:
    if not shares.sum() > 0.0:
        return "–", "–", "–"
    below = np.concatenate(([0.0], np.cumsum(shares)))
    return tuple(f"{number(float(np.interp(at, below, edges)), 3)} {label}".strip() for at in (0.05, 0.5, 0.95))


def loop_chart(diagnosis: Diagnosis) -> Chart | None:
    """Hysteresis loops above each other on common scales; None without loops."""
    if not diagnosis.loops:
        return None
    _, torque_label = shown(str(diagnosis.vehicle.get("torque_unit", "N*m")))
    to_degrees, angle_label = shown("rad")
    titles = (bracketed("steering wheel angle", angle_label), bracketed("torque", torque_label))
    panels, rows = [], []
    for name, (angle, torque) in diagnosis.loops.items():
        angle, torque = np.asarray(angle, float) * to_degrees, np.asarray(torque, float)
        panels.append(Panel(words(name), *titles, (Lines("torque", angle, torque),)))
        half = _half_height(angle, torque, torque_label)
        rows.append((words(name), _range(angle, angle_label), _range(torque, torque_label), half))
    return Chart(
        "loops",
        "Hysteresis",
        "Steering torque over steering wheel angle. Friction opens the loop: half its height in the middle is about "
        "the friction. A closed line means that there was no friction, or that the stroke was too small to show it.",
        f"Torque over angle for {', '.join(map(words, diagnosis.loops))}; sizes in the table beneath.",
        tuple(panels),
        ("loop", "angle", "torque", "half height in the middle"),
        tuple(rows),
        shared_axes=True,
    )


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
