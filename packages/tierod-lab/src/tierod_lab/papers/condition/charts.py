"""Charts of the study: the paper's figures redrawn from virtual drives."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.content import Chart, Lines, Panel, Points
from tierod_lab.papers.condition.datasets import BANK, METHODS, Known, calibrations, ratios_of
from tierod_lab.papers.condition.drives import ASKED, LONG, LOSS, SHORT, THIRD, TORQUES, Drive, Injected, lost
from tierod_lab.papers.condition.recorded import recorded
from tierod_lab.papers.condition.scoring import faulty_times
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Frame

RULES = "rules"  # The diagnosis whose residuals and thresholds are shown
WORDS = {
    "residuals": ("residual / threshold", "Magnitude over the threshold of calibration, which is one."),
    "states": ("state", "1 faulty, 0.5 one of several, 0 fault-free; declared states are drawn a little higher."),
    "signals": ("SI unit", "The reading, the truth, and what the bank expects from the other sensors."),
}
"""Text of the upright axis and note, by what a figure shows."""


def charts(frames: Mapping[str, Frame], effort: Effort) -> Iterator[Chart]:
    """All charts, from the datasets and from drives that are simulated once more."""
    known = calibrations((1,), effort)[1]
    yield _rounds()
    for figure in tomllib.loads(Path(__file__).with_name("figures.toml").read_text("utf-8"))["figure"]:
        yield _redrawn(figure, known)
    yield _accuracies("20", "sensor", frames["sensors"])
    yield _accuracies("25", "actuator", frames["actuators"].where({"test": "all torque"}))


def _rounds() -> Chart:
    panels = []
    for name in (SHORT, LONG, THIRD):
        made = recorded(Drive(name, 80.0, 0))
        x, y = (made[f"truth_position_{axis}"].values[::10] for axis in "xy")
        panels.append(Panel(name, "east (m)", "north (m)", (Lines(name, x, y),), to_scale=True))
    words = "Ways that the demonstrator drove in 80 s.", "Three closed ways with many bends, seen from above."
    return Chart("condition-rounds", "The three rounds (Figures 18, 19, 24)", *words, tuple(panels))


def _redrawn(figure: Mapping[str, Any], known: Known) -> Chart:
    faults = tuple(
        lost(name, 1.0, *span) if name in TORQUES else Injected(name, LOSS, np.nan, *span)
        for name, span in figure.get("fault", {}).items()
    )
    late = any(each.element in TORQUES for each in faults)
    drive = Drive(SHORT, max(60.0, *(each.end for each in faults), 0.0), 1, 21 if late else 11, faults)
    made = recorded(drive)
    time = made["yaw_rate"].time
    shown = np.flatnonzero((time >= figure["span"][0]) & (time < figure["span"][1]))[::3]
    panels = []
    for name, curves in _CURVES[figure["what"]](drive, made, known, figure["names"]).items():
        lines = tuple(Lines(label, time[shown], np.asarray(values)[shown]) for label, values in curves.items())
        uprights = tuple(("fault", each.start) for each in faults[:1])
        panels.append(Panel(name.replace("_", " "), "time (s)", WORDS[figure["what"]][0], lines, uprights=uprights))
    number, title, note = figure["number"], figure["title"], WORDS[figure["what"]][1]
    return Chart(f"condition-figure-{number}", f"{title} (Figure {number})", note, note, tuple(panels))


Curves = dict[str, dict[str, Any]]  # Values by label of the curve, by title of the panel


def _residuals(drive: Drive, made: Any, known: Known, names: list[str]) -> Curves:
    ratios = ratios_of(known, made)
    return {name: {name: ratios[name]} for name in names}


def _states(drive: Drive, made: Any, known: Known, names: list[str]) -> Curves:
    time = made["yaw_rate"].time
    real = faulty_times(drive, time)
    curves: Curves = {name: {"real": 1.0 * real.get(name, np.zeros(len(time)))} for name in names}
    for place, method in enumerate((RULES, BANK), 1):
        said = known.declared(method, made)
        for name in names:
            state = np.maximum(said.said("faulty", name), 0.5 * said.said("candidates", name))
            curves[name][method] = state + 0.03 * place
    return curves


def _signals(drive: Drive, made: Any, known: Known, names: list[str]) -> Curves:
    expected = known.declared(BANK, made).value
    curves: Curves = {}
    for name in names:
        curves[name] = {"true": made[f"truth_{TORQUES.get(name, name)}"].values}
        curves[name]["asked for" if name in ASKED else "read"] = made[ASKED.get(name, name)].values
        if name in expected:
            curves[name]["expected"] = expected[name]
    return curves


_CURVES = {"residuals": _residuals, "states": _states, "signals": _signals}


def _accuracies(number: str, what: str, frame: Frame) -> Chart:
    marks = []
    for method in METHODS:
        groups = dict(frame.where({"method": method}).groups("element"))
        mean, worst = (np.array([join(rows["accuracy"]) for rows in groups.values()]) for join in (np.mean, np.min))
        marks.append(Points(method, tuple(key[0].replace("_", " ") for key in groups), mean, worst, mean))
    note = "Mean over the tests; the line reaches down to the worst. The paper prints more than 0.95 for sensors."
    panel = Panel("accuracy", what, "accuracy", tuple(marks))
    return Chart(f"condition-accuracy-{what}s", f"Accuracy by {what} (Figure {number})", note, note, (panel,))
