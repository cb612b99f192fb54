import dataclasses

import numpy as np
import pytest

from diagnosis_examples import friction_fault, trace
from report_pages import Page, charts
from tierod.findings import Curve, Decided
from tierod.report.charts.decisions import decision_figure, design_figures, statistics
from tierod.report.page import render

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
    assert sorted(shape["y0"] for shape in figure.layout["shapes"]) == [-1.0, 1.0]


def test_the_alarm_is_marked_where_the_statistic_is_beyond(diagnosis):
    marked = next(each for each in decision_figure(diagnosis).data if each.get("name") == "alarm")
    beyond = [x for x, y in zip(marked["x"], marked["y"], strict=True) if y is not None]
    assert min(beyond) * 60.0 == pytest.approx(61.5, abs=2.0)


def test_nothing_is_marked_below_the_threshold(diagnosis):
    quiet = dataclasses.replace(diagnosis, decisions=(decision("on", "excess", (2.0,)),))
    assert [each for each in decision_figure(quiet).data if each.get("name") == "alarm"] == []


def test_rules_of_one_design_share_a_chart(diagnosis):
    figures = design_figures(diagnosis)
    assert [figure.title for figure in figures] == ["Rule of: on; off", "Rule of: fit"]
    assert figures[0].layout["xaxis"]["type"] == "log"
    assert "type" not in figures[1].layout["xaxis"]


def test_the_page_tells_every_rule(diagnosis):
    text = render(diagnosis)
    page = Page(text)
    said = " ".join(" ".join(page.texts).split())
    assert page.open == []
    assert "The rules and their false alarms (5)" in said
    assert {"decisions", "design-0", "design-1"} <= set(charts(text))


def test_a_page_without_decisions_has_no_such_section():
    assert "How it was decided" not in render(friction_fault())
