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
from tierod_lab.campaign.compare import compare
from tierod_lab.campaign.compare import document as comparison_document
from tierod_lab.campaign.report import render_campaign, render_comparison, show, show_comparison
from tierod_lab.campaign.report.charts import box_figure, detection_figure, grid
from tierod_lab.campaign.report.words import NEVER, amount, count, place, seconds, value
from tierod_lab.campaign.summary import document, text

GATES = (gate("detection_worst_s", "<= 10"), gate("false_alarms", "<= 9", fault="fault-free"))
EVIL = "<script>alert(1)</script>"


def content(rows=ROWS, gates=()):
    return json.loads(text(document(summary(rows, gates), f"tierod campaign {EVIL}")))


def printed(function, content_):
    console = Console(width=200, record=True, file=io.StringIO())
    function(content_, console)
    return console.export_text()


def test_the_page_shows_gates_matrix_states_and_failures():
    page = render_campaign(
        content(gates=[gate("detection_worst_s", "<= 10"), gate("false_alarms", "<= 9", fault="fault-free")])
    )
    assert page.startswith("<!doctype html>")
    assert "A pass criterion is missed" in page
    assert re.search(r"detection_<wbr>worst_<wbr>s</th><td[^>]*>all drives</td><td>≤ 10</td><td>never</td>", page)
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
    figure = detection_figure(0, "friction", content(rows)["pools"])
    medians = [curve for curve in figure.data if curve["name"] == "median"]
    assert medians[0]["x"] == [2.0, 4.0, 8.0, 1.0]
    assert medians[0]["y"] == [6.0, 3.5, 2.25, None]
    assert medians[1]["x"] == ["as it is"]
    assert [note["text"] for note in figure.layout["annotations"]] == ["step", "1 never", "lost"]
    assert figure.summary[3] == ("step 1 (0 of 1 found)", "never", "never", "never")


def test_the_goal_of_a_pass_criterion_is_a_line_in_the_chart_of_its_times():
    gates = [gate("detection_worst_s", "<= 10"), gate("detection_median_s", "<= 4", fault="lost"), gate("bias", "<= 1")]
    found = content(gates=gates)
    figure = detection_figure(0, found["monitors"][0]["label"], found["pools"], found["gates"])
    levels = [(shape["yref"], shape["y0"]) for shape in figure.layout["shapes"]]
    assert sorted(levels) == [("y", 10.0), ("y2", 4.0), ("y2", 10.0)]
    assert detection_figure(0, "friction", found["pools"]).layout["shapes"] == []


def test_sizes_with_a_unit_are_numbers_and_other_sizes_are_names():
    rows = [row(1, fault="a", size="2 N*m"), row(1, fault="a", size="4 N*m"), row(1, fault="b", size="summer")]
    figure = detection_figure(0, "friction", content(rows)["pools"])
    assert figure.data[0]["x"] == [2.0, 4.0]
    assert figure.layout["xaxis"]["title"]["text"] == "size [N·m]"
    assert figure.data[3]["x"] == ["summer"]


def test_boxes_show_the_truth():
    figure = box_figure(0, content()["states"][0])
    assert figure.data[0]["x"] == ["fault-free", "step 4", "lost"]
    assert figure.data[1]["y"] == [4.0, 8.0, 8.0]
    assert box_figure(0, {"boxes": [], "unit": ""}) is None


def test_the_grid_counts_what_went_right():
    found = grid(content()["cells"], "friction")
    assert (found.axes, found.columns) == ((), ("fault-free", "step 4", "lost"))
    (levels, squares) = found.rows[0]
    assert levels == ()
    assert [(s.text, s.kind, s.title) for s in squares] == [
        ("1/2", "bad", "1 false alarm"), ("1/2", "bad", "1 missed"), ("0/2", "bad", "1 early, 1 diverged"),
    ]  # fmt: skip


def test_the_terminal_prints_the_same():
    printed_ = printed(
        show, content(gates=[gate("detection_worst_s", "<= 10"), gate("false_alarms", "<= 9", fault="fault-free")])
    )
    assert re.search(r"step 4 +2 +1 of 2 +5 s +never +never", printed_)
    assert "1 drive of 6 failed" in printed_
    assert "diverged: vehicle car, seed 2, lost: gone" in printed_
    assert "✕ MISSED  detection_worst_s <= 10: never; 6 drives" in printed_
    assert "✓ met  false_alarms (fault fault-free) <= 9: 1; 2 drives" in printed_


def test_a_comparison_lists_differences_and_changes(tmp_path):
    first, second = compared(tmp_path / "a", 10.0, 0.1), compared(tmp_path / "b", 7.0, -0.3)
    printed_ = comparison_document(compare(first, second), (first, second), "tierod campaign --compare a b")
    page = render_comparison(printed_)
    assert "0 verdicts of 9 changed; time to the alarm fell by 3 s, bias fell by 0.356 N·m" in page
    assert "differences-0" in page
    text_ = printed(show_comparison, printed_)
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
