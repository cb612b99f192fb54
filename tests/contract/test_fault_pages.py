"""The page of every alarm shows the quantity that decided, up to the alarm and beyond, its threshold and the moment."""

from dataclasses import replace

import numpy as np
import pytest

import report_pages
from exact_vehicle import diagnose
from tierod.core.findings import Status
from tierod.core.shown import shown
from tierod.monitors.registry import MONITORS
from tierod.report.diagnosis import deciding, render
from tierod.report.display import number, time_scale
from tierod.vehicles import load
from tierod_lab.ground import scenarios


def changed(name, change, start=0.0):
    def of(recording):
        channel = recording[name]
        values = np.where(channel.time >= start, change(channel.values), channel.values)
        return recording.with_channels([replace(channel, values=values)])

    return of


def loose_bar(car):
    stiffness = car.parameters["torsion_bar_stiffness"]
    loose = replace(stiffness, value=1.6 * stiffness.value)
    return replace(car, parameters={**car.parameters, stiffness.name: loose})


CASES = {
    "friction": ("mixed-drive-friction-step", 520.0, "midsize-eps", None),
    "sideslip": ("steer-by-wire-sideslip", 20.0, "steer-by-wire", changed("yaw_rate", lambda x: x + 0.03)),
    "driver-torque": ("column-bench-hands", 20.0, "column-bench", loose_bar),
    "motor-angle": ("motor-bench-sweep", 8.0, "motor-bench", changed("motor_angle_mechanical", lambda x: x + 0.1, 5.0)),
    "condition": ("demonstrator-lap", 80.0, "smartload", changed("steering_wheel_angle", lambda x: x + 0.5, 40.0)),
}
"""Of each monitor: scenario, its seconds, vehicle, and what is changed of the recording or of the vehicle."""


@pytest.mark.parametrize("monitor", CASES)
def test_a_page_shows_what_decided(monitor):
    scenario, seconds, name, change = CASES[monitor]
    recording, vehicle = scenarios.load(scenario).with_run(seconds).run().recording, load(name)
    if change is loose_bar:
        vehicle = change(vehicle)
    elif change:
        recording = change(recording)
    if monitor == "motor-angle":
        recording = changed("resolver_sine", lambda x: np.nan * x)(recording)
    diagnosis = diagnose(recording, vehicle, monitor)
    finding, text = diagnosis.findings[0], render(diagnosis)
    assert finding.status.alarm or finding.status is Status.NOT_IDENTIFIABLE, finding.headline
    decided = [each for each in diagnosis.decisions if each.name in finding.decided_by]
    assert len(decided) == len(finding.decided_by) > 0
    said = " ".join(" ".join(report_pages.Page(text).texts).split())
    for each in decided:
        assert each.levels
        (a_chart_shows if each.statistic else a_look_is_shown)(diagnosis, each, text)
    assert all(each.split(":")[0] in said for each in deciding(diagnosis, finding))
    assert monitor in MONITORS


def a_chart_shows(diagnosis, each, text):
    """The statistic is drawn beyond its threshold, with both and the moment."""
    finding, chart = diagnosis.findings[0], report_pages.charts(text)["decisions"]
    trace = report_pages.series(text)[each.statistic]
    factor, _ = shown(diagnosis.traces[each.statistic].unit)
    marks = [mark for mark in chart["data"] if mark.get("meta", {}).get("series") == each.statistic]
    assert {mark["meta"]["part"] for mark in marks} == {"mean", "range", "beyond"}
    (strip,) = {mark["yaxis"] for mark in marks}
    lines = [shape["y0"] for shape in chart["layout"]["shapes"] if shape.get("yref") == strip]
    assert lines == pytest.approx([level * factor for level in each.levels])
    low = each.below or each.reached < 0.0
    side = trace.lower if low else trace.upper
    level = (min if low else max)(each.levels)
    beyond = side <= level + 1e-3 * abs(level) if low else side >= level - 1e-3 * abs(level)
    width = trace.time[1] - trace.time[0]
    # The other side of a two-sided rule may have been passed first.
    assert trace.time[np.argmax(beyond)] + 2.0 * width >= each.passed
    assert (np.nanmin if low else np.nanmax)(side) == pytest.approx(each.reached, rel=1e-2)
    per_second, _ = time_scale(diagnosis.recording["start_s"] + diagnosis.recording["duration_s"])
    left, right = chart["layout"]["xaxis"]["range"]
    assert left <= each.passed * per_second <= right
    uprights = [shape["x0"] for shape in chart["layout"]["shapes"] if shape.get("yref") == "paper"]
    assert min(abs(finding.since * per_second - upright) for upright in uprights) <= 2e-3 * (right - left)


def a_look_is_shown(diagnosis, each, text):
    chart = report_pages.charts(text)["looks"]
    over = {name.lower(): value for mark in chart["data"] for name, value in zip(mark["y"], mark["x"], strict=True)}
    assert over[each.name] >= 1.0
    assert f"{number(each.reached, 3)}, alarm" in " ".join(report_pages.Page(text).texts)
    assert [shape["x0"] for shape in chart["layout"]["shapes"]] == [1.0]
