import dataclasses

import numpy as np
import pytest

from diagnosis_examples import friction_fault, trace
from report_pages import Page, charts
from tierod.core.findings import Curve, Decided
from tierod.report.charts.decisions import (
    decision_figure,
    design_charts,
    looks_chart,
    most_relevant,
    quiet_figure,
    statistics,
)
from tierod.report.diagnosis import deciding, render

TIME = np.arange(0.0, 100.0)
COST = Curve((1.0, 10.0, 100.0), (0.1, 0.2, 0.3), "between false alarms [h]", "delay [s]", (10.0, 0.2))
LOOK = Curve((0.0, 3.0, 6.0), (0.001, 0.5, 1.0), "size", "chance", (3.0, 0.5), chance=True)


def decision(name, statistic="", levels=(), curve=None):
    return Decided(name, "a distance", "a rule", "none in 10 h", "here", statistic, levels, curve)


@pytest.fixture
def diagnosis():
    found = friction_fault()
    values = np.where(TIME > 60.0, 1.5, 0.2)
    traces = {**found.traces, "excess": trace("excess", "", TIME, values)}
    decisions = (
        decision("on", "excess", (1.0,), COST),
        decision("off", "excess", (-1.0,), COST),
        decision("fit", curve=LOOK),
        decision("lost"),
        decision("withheld", "no_such_trace", (1.0,)),
    )
    return dataclasses.replace(found, traces=traces, decisions=decisions)


def test_rules_that_share_a_statistic_share_a_strip(diagnosis):
    assert statistics(diagnosis) == {"excess": [(1.0, False), (-1.0, True)]}
    figure = decision_figure(diagnosis)
    across = [shape["y0"] for shape in figure.layout["shapes"] if shape["yref"] == "y"]
    assert sorted(across) == [-1.0, 1.0]
    assert [shape["x0"] for shape in figure.layout["shapes"] if shape["yref"] == "paper"] == [1811.0 / 60.0]


def test_the_alarm_is_marked_where_the_statistic_is_beyond(diagnosis):
    marked = next(each for each in decision_figure(diagnosis).data if each.get("name") == "alarm")
    beyond = [x for x, y in zip(marked["x"], marked["y"], strict=True) if y is not None]
    assert min(beyond) * 60.0 == pytest.approx(61.5, abs=2.0)


def test_nothing_is_marked_below_the_threshold(diagnosis):
    quiet = dataclasses.replace(diagnosis, decisions=(decision("on", "excess", (2.0,)),))
    assert [each for each in decision_figure(quiet).data if each.get("name") == "alarm"] == []


def test_rules_of_one_design_share_a_chart(diagnosis):
    charts_ = design_charts(diagnosis)
    assert [chart.title for chart in charts_] == ["Rule of: on; off", "Rule of: fit"]
    assert [chart.panels[0].logarithmic_along for chart in charts_] == [True, False]
    assert charts_[1].panels[0].uprights == (("in effect", 3.0),)


def test_the_page_shows_every_rule(diagnosis):
    text = render(diagnosis)
    page = Page(text)
    said = " ".join(" ".join(page.texts).split())
    assert page.open == []
    assert "The rules and their false alarms (5)" in said
    assert {"decisions", "design-0", "design-1"} <= set(charts(text))


def test_a_page_without_decisions_has_no_such_section():
    assert "How it was decided" not in render(friction_fault())


def test_what_decided_stands_first_and_what_stayed_quiet_is_folded_away(diagnosis):
    quiet = trace("calm", "", TIME, np.zeros(100))
    decisions = (
        dataclasses.replace(decision("calm", "calm", (1.0,)), reached=0.0),
        dataclasses.replace(decision("on", "excess", (1.0,)), reached=1.5, passed=61.0),
    )
    finding = dataclasses.replace(diagnosis.findings[0], decided_by=("on",))
    known = dataclasses.replace(
        diagnosis, findings=(finding,), traces={**diagnosis.traces, "calm": quiet}, decisions=decisions
    )
    assert most_relevant(known) == ["excess"]
    assert {mark["meta"]["series"] for mark in quiet_figure(known).data} == {"calm"}
    assert deciding(known, finding) == ["On: 1.5, alarm from 1, first at 1 min 1 s"]
    assert most_relevant(dataclasses.replace(known, findings=(), decisions=decisions[:1])) == ["calm"]


def test_what_rules_saw_at_the_end_stands_beside_their_thresholds(diagnosis):
    decisions = (
        dataclasses.replace(decision("apart", levels=(4.0, -4.0)), reached=-8.0),
        dataclasses.replace(decision("covered", levels=(0.8,)), below=True, reached=0.4),
        dataclasses.replace(decision("fits", levels=(4.0, -4.0)), reached=1.0),
        decision("unseen", levels=(4.0,)),
    )
    chart = looks_chart(dataclasses.replace(diagnosis, decisions=decisions))
    within, beyond = chart.panels[0].marks
    assert (within.x, within.y) == (["Fits"], [0.25])
    assert (beyond.x, beyond.y) == (["Apart", "Covered"], [2.0, 2.0])
    assert [row[1] for row in chart.summary] == ["−8, alarm beyond ±4", "0.4, alarm below 0.8", "1, alarm beyond ±4"]
    assert looks_chart(friction_fault()) is None
