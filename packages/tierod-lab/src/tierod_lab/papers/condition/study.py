"""The study of condition monitoring: the paper's rules beside the bank of filters, more faults, real cars."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.content import Chart, Item, Lines, Panel, Points, Table
from tierod_lab.papers.condition import datasets, drives
from tierod_lab.papers.condition.datasets import BANK, METHODS, SHIPPED, Task, calibrations, tasks, vehicles
from tierod_lab.papers.condition.drives import LONG, OFFSETS, SENSORS, SHORT, THIRD, TORQUES, Drive, Injected
from tierod_lab.papers.condition.recorded import ODD, recorded
from tierod_lab.papers.condition.scoring import faulty_times
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.studies import engine
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame

SMALL = (0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.4, 0.55, 0.75, 1.0)
"""Small offsets, in multiples of those of the tests."""


def _sensors(effort: Effort, swing: bool = True) -> list[Drive]:
    found = [each for number in vehicles(effort) for each in drives.sensor_tests(number, swing=swing)]
    return found[::5] if effort.quick else found


def _losses(effort: Effort, share: float, swing: bool = True) -> list[Drive]:
    found = [each for number in vehicles(effort) for each in drives.actuator_tests(number, share, swing)]
    return found[::8] if effort.quick else found


def _supplies(effort: Effort, share: float, swing: bool = True) -> list[Drive]:
    found = [each for number in vehicles(effort) for each in drives.supply_tests(number, share, swing)]
    return found[:2] if effort.quick else found


def _actuators(effort: Effort) -> list[Task]:
    return [
        *tasks(_losses(effort, 1.0), effort, METHODS, "all torque"),
        *tasks(_losses(effort, 0.5), effort, METHODS, "half the torque"),
        *tasks(_losses(effort, 0.5, False), effort, test="half the torque"),
        *tasks(_supplies(effort, 1.0), effort, test="both, all torque"),
        *tasks(_supplies(effort, 0.5), effort, test="both, half the torque"),
        *tasks(_supplies(effort, 0.5, False), effort, test="both, half the torque"),
    ]


def _uncalibrated(effort: Effort) -> list[Task]:
    plans = zip(vehicles(effort), ((SHORT, 81), (LONG, 82), (THIRD, 83)), strict=False)
    kinds = [each for number, plan in plans for each in drives.more_kinds(number, *plan) if _tested(each.injected[0])]
    hours = drives.healthy_drives(0.05 if effort.quick else 1.0, vehicles(effort))
    groups = {
        "sensors": _sensors(effort, swing=False),
        "actuators": _losses(effort, 1.0, swing=False),
        "kinds": kinds[::6] if effort.quick else kinds,
        "fault-free": hours,
    }
    return [each for test, several in groups.items() for each in tasks(several, effort, (SHIPPED,), test)]


def _tested(fault: Injected) -> bool:
    """Whether a kind is named without a calibration: positive offsets, too large gains, noise and delays."""
    return fault.kind in ("noise", "delay") or fault.size > {"offset": 0.0, "gain": 1.0}.get(fault.kind, float("inf"))


def _healthy(effort: Effort) -> list[Task]:
    methods = (BANK,) if effort.thorough else METHODS
    hours, later = (0.1, 0.1) if effort.quick else (100.0, 20.0) if effort.thorough else (3.0, 1.0)
    return [
        *tasks(drives.healthy_drives(hours, vehicles(effort)), effort, methods, "as calibrated"),
        *tasks(drives.changed_drives(later, vehicles(effort)), effort, methods, "10 % off"),
    ]


def _beyond(effort: Effort) -> list[Task]:
    plans = [
        (number, *plan) for number, plan in zip(vehicles(effort), ((SHORT, 31), (LONG, 32), (THIRD, 33)), strict=False)
    ]
    kinds = [each for plan in plans for each in drives.more_kinds(*plan, sizes=(0.5, 1.0, 2.0))]
    pairs = [each for number, course, seed in plans[:2] for each in drives.pairs(number, course, seed + 10)]
    small = [
        Drive(course, 60.0, number, seed + 20, (Injected(sensor, "offset", size * OFFSETS[sensor]),))
        for sensor in SENSORS
        for size in SMALL
        for number, course, seed in plans
    ]
    groups: dict[str, Sequence[Drive]] = {
        "kinds": kinds[::10] if effort.quick else kinds,
        "pairs": pairs[::13] if effort.quick else pairs,
        "small": small[::5] if effort.quick else small,
    }
    return [each for test, several in groups.items() for each in tasks(several, effort, test=test)]


def _substitutes(effort: Effort) -> list[Task]:
    offsets = [
        Drive(course, 60.0, number, 400 + number, (Injected(sensor, "offset", OFFSETS[sensor]),))
        for number in vehicles(effort)
        for course in ((SHORT,) if effort.quick else (SHORT, LONG))
        for sensor in SENSORS
    ]
    return tasks([*drives.healthy_drives(0.1 if effort.quick else 1.0, vehicles(effort)), *offsets], effort)


DATASETS = (
    Dataset(
        "racks",
        "The steering as two bodies (eqs 3, 4)",
        datasets.racks,
        lambda effort: ["one body", "angle once", "angle twice"],
    ),
    Dataset(
        "residuals",
        "Sensitivity of the residuals",
        datasets.residuals,
        lambda effort: tasks(drives.sensor_tests(1)[:: 7 if effort.quick else 1], effort),
    ),
    Dataset("late", "A motor of which little is asked", datasets.late, lambda effort: [calibrations((1,), effort)[1]]),
    Dataset(
        "sensors",
        "The 48 tests of the sensors",
        datasets.sensors,
        lambda effort: tasks(_sensors(effort), effort, METHODS),
    ),
    Dataset("actuators", "The tests of the actuators", datasets.actuators, _actuators),
    Dataset("substitutes", "Substitutes of the sensors", datasets.substitutes, _substitutes),
    Dataset("beyond", "More faults, and two at once", datasets.beyond, _beyond),
    Dataset("uncalibrated", "Vehicles without a calibration", datasets.uncalibrated, _uncalibrated),
    Dataset("healthy", "Fault-free driving", datasets.healthy, _healthy),
    Dataset(
        "odd",
        "Odd recordings of a fault-free vehicle",
        datasets.odd,
        lambda effort: [(name, calibrations((1,), effort)[1]) for name in tuple(ODD)[:: 5 if effort.quick else 1]],
    ),
    Dataset(
        "real",
        "Faults put into recordings of real cars",
        datasets.real,
        lambda effort: [(0, effort.quick), (1, effort.quick)],
        NO_DATA,
    ),
)
"""The datasets, in the order of the report."""

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


def _redrawn(figure: Mapping[str, Any], known: datasets.Known) -> Chart:
    faults = tuple(
        drives.lost(name, 1.0, *span) if name in TORQUES else Injected(name, drives.LOSS, np.nan, *span)
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


def _residuals(drive: Drive, made: Any, known: datasets.Known, names: list[str]) -> Curves:
    ratios = datasets.ratios_of(known, made)
    return {name: {name: ratios[name]} for name in names}


def _states(drive: Drive, made: Any, known: datasets.Known, names: list[str]) -> Curves:
    time = made["yaw_rate"].time
    real = faulty_times(drive, time)
    curves: Curves = {name: {"real": 1.0 * real.get(name, np.zeros(len(time)))} for name in names}
    for place, method in enumerate((RULES, BANK), 1):
        said = known.declared(method, made)
        for name in names:
            state = np.maximum(said.said("faulty", name), 0.5 * said.said("candidates", name))
            curves[name][method] = state + 0.03 * place
    return curves


def _signals(drive: Drive, made: Any, known: datasets.Known, names: list[str]) -> Curves:
    expected = known.declared(BANK, made).value
    curves: Curves = {}
    for name in names:
        curves[name] = {"true": made[f"truth_{TORQUES.get(name, name)}"].values}
        curves[name]["asked for" if name in drives.ASKED else "read"] = made[drives.ASKED.get(name, name)].values
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


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress, charts)
    rows = tuple((f"{number}", f"{number + 10}", f"{number + 20}") for number in vehicles(effort))
    note = (
        "The numbers follow from the digest of the bank of filters of smartload, traced graph and tuning. Those up to "
        f"{datasets.USED} were driven while thresholds were chosen; none of them is reported."
    )
    header = ("demonstrator, drawn by", "tests of sensors", "tests of actuators")
    yield Table("Seeds of the reported drives", header, rows, note)
