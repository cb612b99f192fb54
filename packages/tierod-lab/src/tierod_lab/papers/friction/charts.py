"""Charts of the study of friction: the paper's Figures 3 and 5 to 10."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from tierod.core.content import Bars, Boxes, Chart, Lines, Panel, Points
from tierod_lab.papers.friction.cases import STATES
from tierod_lab.papers.friction.judging import DEFAULT, FILTERS, KEPT, PRINTED, RATE, READY, aligned, course, judged
from tierod_lab.papers.friction.paper_datasets import SUPPORTS, TABLE_1, THRESHOLD, WORST, set_drives
from tierod_lab.papers.friction.reported import monitor
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Frame

HISTOGRAMS = {
    "3": ("rolling error variances, development set", "variance over 15 s [(N·m)²]"),
    "7": ("estimates of the printed filter", "estimated friction [N·m]"),
    "9": ("the same by tyres", "estimated friction [N·m]"),
}
"""Subject and axis of each figure of histograms."""


def charts(frames: Mapping[str, Frame], effort: Effort) -> Iterator[Chart]:
    """All charts, from the datasets and from two drives that are simulated once more."""
    sets = frames["sets"]
    for number, (what, along) in HISTOGRAMS.items():
        panels = _histograms(sets, number, along, THRESHOLD if number == "7" else None)
        read = f"Histograms of healthy and faulty steering: {what}."
        yield Chart(f"figure-{number}", f"Figure {number}: {what}, healthy against {WORST}", "", read, panels)
    for number, state in (("5", "Healthy"), ("6", WORST)):
        yield _course_chart(number, state, effort)
    yield _boxes(sets)
    yield _turns(frames["turns"])


def _histograms(sets: Frame, number: str, along: str, limit: float | None) -> tuple[Panel, ...]:
    panels = []
    for (figure,), rows in sets.groups("figure"):
        name, _, title = figure.partition(", ")
        if name == number:
            marks = tuple(
                Bars(group, np.append(bars["low"], bars["high"][-1]), bars["share"])
                for (group,), bars in rows.groups("group")
            )
            panels.append(Panel(title, along, "share", marks, uprights=(("threshold", limit),) if limit else ()))
    return tuple(panels)


def _course_chart(number: str, state: str, effort: Effort) -> Chart:
    case = next(each.case for each in set_drives(effort) if each.state == state)
    block = FILTERS[PRINTED]()
    samples = aligned(case.recording(), monitor(), block)
    printed, (default, _) = course(block, samples), judged(samples)
    time = np.arange(len(printed.friction)) * (KEPT / RATE) / 60.0
    angle = np.degrees(samples.values[::KEPT, samples.names.index("steering_wheel_angle")])
    ready = printed.enabled > READY
    begins = float(time[np.argmax(ready)]) if ready.any() else math.nan
    marks = (Lines("printed filter", time, printed.friction), Lines("default estimator", time, default.friction))
    return Chart(
        f"figure-{number}",
        f"Figure {number}: friction estimated on a drive, {state}",
        "Above the steering profile, beneath the estimates of the printed filter and of tierod's default estimator. "
        "Dashed: the true friction. The paper leaves out the first 50 s of enabled time.",
        f"Estimate of the printed filter over a drive with {STATES[state]:g} N·m; it starts at 3 N·m.",
        (
            Panel("steering profile", "time [min]", "angle [°]", (Lines("steering wheel angle", time, angle),)),
            Panel(
                "estimated friction",
                "time [min]",
                "friction [N·m]",
                marks,
                levels=(("true friction", STATES[state]),),
                uprights=(("50 s enabled", begins),) if math.isfinite(begins) else (),
            ),
        ),
    )


def _boxes(sets: Frame) -> Chart:
    states = list(STATES)
    marks: list[Boxes | Points] = []
    for method in (PRINTED, DEFAULT):
        rows = sets.where({"figure": "", "method": method, "state": states})
        marks.append(Boxes.normal(method, states, list(rows["mean"]), list(rows["deviation"])))
    return Chart(
        "figure-8",
        "Figure 8: friction estimates of all data",
        "Boxes: one standard deviation about the mean; whiskers: two. Points: truth.",
        "Mean and spread of the estimates of every health state beside the true friction.",
        (Panel("", "health state", "friction [N·m]", (*marks, Points("truth", states, list(STATES.values())))),),
    )


def _turns(turns: Frame) -> Chart:
    marks = []
    for support in SUPPORTS:
        rows = turns.where({"support": support})
        marks.append(Points(support, rows["pwm"], rows["increase"]))
    lows, highs = zip(*TABLE_1.values(), strict=True)
    middles = [0.5 * (low + high) for low, high in TABLE_1.values()]
    marks.append(Points("printed, Table 1", list(TABLE_1), middles, lows, highs))
    return Chart(
        "figure-10",
        "Figure 10: friction increase estimated from lock-to-lock turns",
        "One mark per turn; bars: the ranges printed in Table 1.",
        "Estimated increase of friction over the setting of the brake, on hoist and ground, with the printed ranges.",
        (Panel("", "PWM [%]", "increase of friction [N·m]", tuple(marks)),),
    )
