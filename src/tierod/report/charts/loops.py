"""The hysteresis view: steering torque over the angle of the steering wheel."""

from __future__ import annotations

import numpy as np

from tierod.findings import Diagnosis
from tierod.report.charts.figure import AMBER, BLUE, GREEN, GREY, RED, Figure, axis, layout, rounded
from tierod.report.display import bracketed, number, shown, words

_COLOURS = (BLUE, AMBER, RED, GREEN, GREY)
_DASHES = ("solid", "dash", "dot", "dashdot")


def loop_figure(diagnosis: Diagnosis) -> Figure | None:
    """All hysteresis views of the diagnosis in one chart; None where there is none."""
    if not diagnosis.loops:
        return None
    _, torque_label = shown(str(diagnosis.vehicle.get("torque_unit", "N*m")))
    to_degrees, angle_label = shown("rad")
    data, rows = [], []
    for index, (name, (angle, torque)) in enumerate(diagnosis.loops.items()):
        angle, torque = np.asarray(angle, float) * to_degrees, np.asarray(torque, float)
        looks = {"color": _COLOURS[index % len(_COLOURS)], "width": 1.1, "dash": _DASHES[index % len(_DASHES)]}
        data.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": words(name),
                "x": rounded(angle),
                "y": rounded(torque),
                "line": looks,
                "opacity": 0.8,
                "hovertemplate": "%{x:.4g}°, %{y:.4g} " + torque_label + f"<extra>{words(name)}</extra>",
            }
        )
        rows.append(
            (words(name), _range(angle, angle_label), _range(torque, torque_label), _width(angle, torque, torque_label))
        )
    return Figure(
        name="loops",
        title="Hysteresis",
        caption="Steering torque over steering wheel angle. Friction opens the loop: half its height in the middle is "
        "about the friction. A closed line means that there was none, or that the stroke was too small to see it.",
        alternative=f"Torque over angle for {', '.join(map(words, diagnosis.loops))}; sizes in the table beneath.",
        data=data,
        layout=layout(
            430,
            xaxis=axis(bracketed("steering wheel angle", angle_label)),
            yaxis=axis(bracketed("steering torque", torque_label)),
            showlegend=True,
        ),
        height=430,
        summary=rows,
        columns=("loop", "angle", "torque", "half height in the middle"),
    )


def _range(values: np.ndarray, label: str) -> str:
    seen = values[np.isfinite(values)]
    return f"{number(float(seen.min()), 3)} to {number(float(seen.max()), 3)} {label}" if len(seen) else "–"


def _width(angle: np.ndarray, torque: np.ndarray, label: str) -> str:
    """Half the distance between the way there and the way back, in the middle third of the angle."""
    step = np.gradient(angle) if len(angle) > 1 else np.zeros(len(angle))
    low, high = (np.nanmin(angle), np.nanmax(angle)) if np.isfinite(angle).any() else (0.0, 0.0)
    middle = np.abs(angle - 0.5 * (low + high)) <= (high - low) / 6.0
    there, back = torque[middle & (step > 0.0)], torque[middle & (step < 0.0)]
    if not np.isfinite(there).any() or not np.isfinite(back).any():
        return "–"
    return f"{number(0.5 * float(np.nanmedian(there) - np.nanmedian(back)), 3)} {label}"
