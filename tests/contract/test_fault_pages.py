"""The page of every alarm shows the quantity that decided, up to the alarm and beyond, its threshold and the moment."""

import math
from dataclasses import replace

import numpy as np
import pytest

import report_pages
from exact_vehicle import diagnose
from tierod.cli import main
from tierod.core.findings import Status
from tierod.core.recording import Channel
from tierod.core.shown import shown
from tierod.io.readers import read
from tierod.monitors.baseline import Baseline
from tierod.monitors.registry import MONITORS
from tierod.physics.clarke_park import StatorVector, inverse_clarke
from tierod.report.diagnosis import deciding, render
from tierod.report.display import number, time_scale
from tierod.vehicles import load

SCENARIOS = {
    "friction": ("mixed-drive-friction-step", "520"),
    "hysteresis": ("lock-to-lock-on-hoist", None),
    "sideslip": ("steer-by-wire-sideslip", "20"),
    "driver-torque": ("column-bench-hands", "20"),
    "motor-angle": ("motor-bench-sweep", "8"),
    "condition": ("demonstrator-lap", "80"),
}


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder, driven = tmp_path_factory.mktemp("drives"), {}

    def of(monitor):
        if monitor not in driven:
            scenario, seconds = SCENARIOS[monitor]
            path = folder / f"{monitor}.parquet"
            limit = ["--seconds", seconds] if seconds else []
            assert main(["simulate", scenario, "-o", str(path), "--json", *limit]) == 0
            driven[monitor] = read(path)
        return driven[monitor]

    return of


def changed(recording, name, change, start=0.0):
    channel = recording[name]
    values = np.where(channel.time >= start, change(channel.values), channel.values)
    return recording.with_channels([replace(channel, values=values)])


def vehicle(name, **factors):
    car = load(name)
    own = {
        key: replace(car.parameters[key], value=factor * car.parameters[key].value) for key, factor in factors.items()
    }
    return replace(car, parameters={**car.parameters, **own})


def with_duty_cycles(whole):
    alpha, beta = (whole[f"motor_target_voltage_{axis}"] for axis in ("alpha", "beta"))
    supply = np.nanmedian(whole["supply_voltage"].values)
    phases = zip("abc", inverse_clarke(StatorVector(alpha.values, beta.values)), strict=True)
    return whole.with_channels(
        Channel(f"motor_duty_cycle_{name}", alpha.time, 0.5 + values / supply, "") for name, values in phases
    )


def friction(whole, variant):
    if variant.startswith("baseline"):
        return diagnose(
            whole, vehicle("midsize-eps", baseline_variance=1e-4), "friction", "baseline-ungated", spread=False
        )
    return diagnose(whole, "midsize-eps", "friction", variant)


def hysteresis(whole, variant):
    level = Baseline("midsize-eps", f"hysteresis, {variant}", 4.0, 0.1, "N*m", 60.0)
    return diagnose(whole, "midsize-eps", "hysteresis", variant, baseline=level)


def sideslip(whole, variant):
    return diagnose(changed(whole, "yaw_rate", lambda x: x + 0.03), "steer-by-wire", "sideslip", variant)


def driver_torque(whole, variant):
    return diagnose(whole, vehicle("column-bench", torsion_bar_stiffness=1.6), "driver-torque", variant)


def motor_angle(whole, variant):
    offset = changed(with_duty_cycles(whole), "motor_angle_mechanical", lambda x: x + 0.1, 5.0)
    offset = changed(offset, "resolver_sine", lambda x: np.nan * x)
    return diagnose(offset, "motor-bench", "motor-angle", variant)


def condition(whole, variant):
    lost = changed(whole, "steering_wheel_angle", lambda x: x + 0.5, 40.0)
    return diagnose(lost, "smartload", "condition", variant)


MAKERS = {
    "friction": friction,
    "hysteresis": hysteresis,
    "sideslip": sideslip,
    "driver-torque": driver_torque,
    "motor-angle": motor_angle,
    "condition": condition,
}
OTHER_THRESHOLDS = (("condition", "rules-discriminating"), ("condition", "rules-printed"))
"""Variants that have the structure of "rules", whose page is looked at always."""

CASES = [
    pytest.param(monitor, variant, marks=pytest.mark.slow if (monitor, variant) in OTHER_THRESHOLDS else ())
    for monitor in MONITORS
    for variant in MONITORS[monitor].variants
]

ELECTRICAL = {
    "supply low": ("supply_voltage", lambda x: x - 6.0),
    "angle leaps": ("motor_angle_mechanical", lambda x: x + 1.5 * (np.arange(len(x)) < 5100)),
    "resolver amplitude": ("resolver_sine", lambda x: 0.6 * x),
    "resolver mismatch": ("resolver_sine", lambda x: -x),
    "stuck": ("motor_angle_mechanical", lambda x: 0.0 * x + x[5000]),
    "current saturated": ("motor_current_alpha", lambda x: np.clip(x, -4.0, 4.0)),
    "voltage saturated": ("motor_voltage_beta", lambda x: np.clip(x, -1.5, 1.5)),
}


@pytest.mark.parametrize(("monitor", "variant"), CASES)
def test_a_page_shows_what_decided(recording, monitor, variant):
    diagnosis = MAKERS[monitor](recording(monitor), variant)
    finding = diagnosis.findings[0]
    assert finding.status.alarm or finding.status is Status.NOT_IDENTIFIABLE, finding.headline
    the_page_shows_what_decided(diagnosis)


@pytest.mark.parametrize("decision", ELECTRICAL)
def test_a_page_shows_whichever_test_of_the_motor_decided(recording, decision):
    name, change = ELECTRICAL[decision]
    whole = recording("motor-angle")
    if name != "resolver_sine":
        whole = changed(whole, "resolver_sine", lambda x: np.nan * x)
    diagnosis = diagnose(changed(whole, name, change, 5.0), "motor-bench", "motor-angle")
    assert diagnosis.findings[0].decided_by == (decision,)
    the_page_shows_what_decided(diagnosis)


def the_page_shows_what_decided(diagnosis):
    finding, text = diagnosis.findings[0], render(diagnosis)
    decided = [each for each in diagnosis.decisions if each.name in finding.decided_by]
    assert len(decided) == len(finding.decided_by) > 0
    said = " ".join(" ".join(report_pages.Page(text).texts).split())
    for each in decided:
        assert each.reached is not None
        assert each.levels
        if each.statistic:
            a_chart_shows(diagnosis, each, text)
        else:
            a_look_is_shown(each, text)
    assert all(each.split(":")[0] in said for each in deciding(diagnosis, finding))
    the_size_fits(finding)


def a_chart_shows(diagnosis, each, text):
    """The statistic is drawn beyond its threshold, with both and the moment, from beginning to end."""
    finding, chart = diagnosis.findings[0], report_pages.charts(text)["decisions"]
    trace = report_pages.series(text)[each.statistic]
    factor, _ = shown(diagnosis.traces[each.statistic].unit)
    marks = [mark for mark in chart["data"] if mark.get("meta", {}).get("series") == each.statistic]
    assert {mark["meta"]["part"] for mark in marks} == {"mean", "range", "beyond"}
    strip = {mark["yaxis"] for mark in marks}
    assert len(strip) == 1
    lines = [shape["y0"] for shape in chart["layout"]["shapes"] if shape.get("yref") in strip]
    assert lines == pytest.approx([level * factor for level in each.levels])
    width = trace.time[1] - trace.time[0]
    last = diagnosis.recording["start_s"] + diagnosis.recording["duration_s"]
    assert trace.time[-1] + 1.01 * width >= last
    low = each.below or each.reached < 0.0
    side = trace.lower if low else trace.upper
    level = (min if low else max)(each.levels)
    room = 1e-3 * abs(level)
    beyond = (side <= level + room) if low else (side >= level - room)
    # The other side of a two-sided rule may have been passed first.
    assert trace.time[np.argmax(beyond)] + 2.0 * width >= each.passed
    assert (np.nanmin if low else np.nanmax)(side) == pytest.approx(each.reached, rel=1e-2)
    per_second, _ = time_scale(last)
    left, right = chart["layout"]["xaxis"]["range"]
    assert left <= each.passed * per_second <= right
    assert right >= last * per_second * 0.999
    uprights = [shape["x0"] for shape in chart["layout"]["shapes"] if shape.get("yref") == "paper"]
    passed = min(other.passed for other in diagnosis.decisions if other.name in finding.decided_by and other.passed)
    moments = [moment * per_second for moment in (finding.since, passed) if moment is not None]
    # One line stands for both where they all but coincide.
    assert [min(abs(at - upright) for upright in uprights) for at in moments] == pytest.approx(
        [0.0] * len(moments), abs=2e-3 * (right - left)
    )
    assert all(left <= upright <= right for upright in uprights)


def a_look_is_shown(each, text):
    chart = report_pages.charts(text)["looks"]
    over = {name.lower(): value for mark in chart["data"] for name, value in zip(mark["y"], mark["x"], strict=True)}
    assert over[each.name] >= 1.0
    assert f"{number(each.reached, 3)}, alarm" in " ".join(report_pages.Page(text).texts)
    assert [shape["x0"] for shape in chart["layout"]["shapes"]] == [1.0]


def the_size_fits(finding):
    """A size beside a limit is beyond it where the fault was found."""
    if finding.status is not Status.FAULT or finding.estimate is None:
        return
    assert math.isfinite(finding.estimate.value)
    for name, level in finding.estimate.reference.items():
        if "fault" in name or "alarm" in name:
            assert abs(finding.estimate.value) >= level
