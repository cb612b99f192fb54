"""Pages and tables of campaigns and comparisons, from their documents alone."""

import io
import json
import math
import re

import pytest
from rich.console import Console

from experiments.campaign_rows import row
from experiments.test_compare import campaign as compared
from experiments.test_summary import ROWS, STEP, gate, summary
from tierod.core.content import Points
from tierod.report.terminal import show
from tierod_lab.campaign.comparison import compare, render_comparison, shown_comparison
from tierod_lab.campaign.comparison import document as comparison_document
from tierod_lab.campaign.report import (
    NEVER,
    amount,
    box_chart,
    count,
    detection_chart,
    grid,
    place,
    render_campaign,
    seconds,
    shown_items,
    value,
)
from tierod_lab.campaign.summary import document, text

GATES = (gate("detection_worst_s", "<= 10"), gate("false_alarms", "<= 9", fault="fault-free"))
EVIL = "<script>alert(1)</script>"


def content(rows=ROWS, gates=()):
    return json.loads(text(document(summary(rows, gates), f"tierod campaign {EVIL}")))


def printed(items):
    console = Console(width=200, record=True, file=io.StringIO())
    show(items, console)
    return console.export_text()


def test_the_page_shows_gates_matrix_states_and_failures():
    page = render_campaign(
        content(gates=[gate("detection_worst_s", "<= 10"), gate("false_alarms", "<= 9", fault="fault-free")])
    )
    assert page.startswith("<!doctype html>")
    assert "A pass criterion is missed" in page
    assert re.search(r"detection_worst_s</th><td[^>]*>all drives</td>.*?≤ 10</td><td[^>]*>never</td>", page)
    assert "2/2" not in page.split("<script")[0]
    assert "1 false alarm" in page
    assert "1 diverged" in page
    assert "gone" in page
    assert "State given, verdict found" in page


def test_the_page_stands_alone_and_lets_no_name_become_markup():
    page = render_campaign(content())
    assert EVIL not in page
    assert "&lt;script&gt;alert(1)" in page
    assert not re.search(r"""(src|href)=["']?https?://""", page.split("<script>")[0])


def test_a_campaign_of_fault_free_drives_has_a_page_too():
    page = render_campaign(content([row(1), row(2)]))
    assert "How soon faults are found" not in page
    assert "What was estimated" in page


def test_a_campaign_in_which_everything_failed_has_a_page_too():
    page = render_campaign(content([row(1, outcome="failed", reason="no tyre")]))
    assert "no tyre" in page
    assert "Not everything could be judged" in page


def test_detection_curves_have_a_panel_per_fault_in_the_order_of_the_matrix():
    rows = [
        *(row(seed, fault="step", size=size, detection_s=10.0 / size + seed) for size in (2, 4, 8) for seed in (1, 2)),
        row(1, fault="step", size=1, verdict="missed"), row(1, fault="lost", detection_s=3.0),
    ]  # fmt: skip
    chart = detection_chart(0, "friction", content(rows)["pools"])
    medians = [next(mark for mark in panel.marks if isinstance(mark, Points)) for panel in chart.panels]
    assert medians[0].x == [2.0, 4.0, 8.0, 1.0]
    assert medians[0].y == [6.0, 3.5, 2.25, pytest.approx(math.nan, nan_ok=True)]
    assert medians[1].x == ["as it is"]
    assert [panel.title for panel in chart.panels] == ["step: 1 never found", "lost"]
    assert chart.summary[3] == ("step 1 (0 of 1 found)", "never", "never", "never")


def test_the_goal_of_a_pass_criterion_is_a_line_in_the_chart_of_its_times():
    gates = [gate("detection_worst_s", "<= 10"), gate("detection_median_s", "<= 4", fault="lost"), gate("bias", "<= 1")]
    found = content(gates=gates)
    chart = detection_chart(0, found["monitors"][0]["label"], found["pools"], found["gates"])
    worst, median = ("goal of the worst time", 10.0), ("goal of the median time", 4.0)
    assert [panel.levels for panel in chart.panels] == [(worst,), (worst, median)]
    assert {panel.levels for panel in detection_chart(0, "friction", found["pools"]).panels} == {()}


def test_sizes_with_a_unit_are_numbers_and_other_sizes_are_names():
    rows = [row(1, fault="a", size="2 N*m"), row(1, fault="a", size="4 N*m"), row(1, fault="b", size="summer")]
    first, second = detection_chart(0, "friction", content(rows)["pools"]).panels
    assert (first.marks[0].x, first.x_title) == ([2.0, 4.0], "size [N·m]")
    assert second.marks[0].x == ["summer"]


def test_boxes_show_the_truth():
    boxes, truth = box_chart(0, content()["states"][0]).panels[0].marks
    assert boxes.places == ["fault-free", "step 4", "lost"]
    assert truth.y == [4.0, 8.0, 8.0]
    assert box_chart(0, {"boxes": [], "unit": ""}) is None


def test_the_grid_counts_what_went_right():
    found = grid(content()["cells"], "friction")
    assert found.header == ("", "fault-free", "step 4", "lost")
    ((level, *squares),) = found.rows
    assert level == "all"
    assert [(str(square), square.colour) for square in squares] == [
        ("1/2: 1 false alarm", "bad"), ("1/2: 1 missed", "bad"), ("0/2: 1 early, 1 diverged", "bad"),
    ]  # fmt: skip


def test_the_terminal_prints_the_same():
    gates = [gate("detection_worst_s", "<= 10"), gate("false_alarms", "<= 9", fault="fault-free")]
    printed_ = printed(shown_items(content(gates=gates)))
    assert re.search(r"step 4 +2 +1 of 2 +5 s +never +never", printed_)
    assert "1 drive of 6 failed" in printed_
    assert re.search(r"diverged +vehicle car, seed 2, lost +gone", printed_)
    assert re.search(r"detection_worst_s +all drives +friction +≤ 10 +never +✕ MISSED +6 drives", printed_)
    assert re.search(r"false_alarms +fault-free +friction +≤ 9 +1 +✓ MET +2 drives", printed_)


def test_a_comparison_lists_differences_and_changes(tmp_path):
    first, second = compared(tmp_path / "a", 10.0, 0.1), compared(tmp_path / "b", 7.0, -0.3)
    printed_ = comparison_document(compare(first, second), (first, second), "tierod campaign --compare a b")
    page = render_comparison(printed_)
    assert "0 verdicts of 9 changed; time to the alarm fell by 3 s, bias fell by 0.356 N·m" in page
    assert "differences-0" in page
    text_ = printed(shown_comparison(printed_))
    assert re.search(r"Time to the alarm +8 +−3 s +−3 s to −3 s +−3 s +0 / 8 +0.0078", text_)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        (seconds("inf"), NEVER),
        (seconds(None), "–"),
        (count(1, "drive"), "1 drive"),
        (place({}), "all drives"),
        (place({"car": "a", "fault": "step", "size": "4", "seed": "1"}), "car a, seed 1, step 4"),
        (amount(0.5, "rad"), "28.6 °"),
    ],
)
def test_figures_in_words(written, meant):
    assert written == meant


def test_numbers_of_the_document():
    assert value("inf") == math.inf
    assert math.isnan(value(None))
    assert STEP["size"] == 4
