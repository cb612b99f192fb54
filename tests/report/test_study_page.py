import math

import numpy as np
import pytest

from report_pages import Page, charts
from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Band, Bars, Boxes, Cells, Chart, Heading, Lines, Panel, Points, Table
from tierod.report.charts.panels import panel_figure
from tierod_lab.studies.page import StudyPage, render_study

CLAIMS = (
    Claim("paper.a", "It is <small>.", "Somebody, section 2", "1.5 to 2.2", 0.2, at_most(0.3), "N*m", "in few drives"),
    Claim("paper.b", "It is large.", "Somebody, section 3", 0.36, 0.02, at_least(0.3)),
    Claim("other.c", "It was tried in vain.", "tierod", None, math.nan, at_most(1.0)),
    Claim("other.d", "It cannot be seen.", "Somebody", None, None, at_most(1.0), derived=0.55),
    Claim("other.e", "It is as long as it is.", "Somebody", 7.25, 7.0, None, "m"),
)
CHART = Chart(
    "spread",
    "Spread",
    "How to read it.",
    "What it shows.",
    (
        Panel("Upper", "x", "share", (Bars("healthy", [0, 1, 2], [0.25, 0.75]), Lines("mean", [0, 1], [1, math.nan]))),
        Panel(
            "Lower",
            "state",
            "friction [N·m]",
            (
                Boxes.normal("healthy", ["H"], [4.0], [0.5]),
                Points("truth", ["H"], [4.0], [3.5], [4.5]),
            ),
            levels=(("limit", 100.0),),
            uprights=(("here", 1.0),),
            logarithmic=True,
        ),
    ),
)


def page(*items, groups=None):
    return StudyPage(
        "one", "One study", "What it is about.", {"paper": "The paper"} if groups is None else groups, items
    )


@pytest.fixture(scope="module")
def text():
    return render_study(
        page(*CLAIMS[:3], Heading("Spread", ("Words.",)), CHART, *CLAIMS[3:], Table("T", ("a",), (("1",),)))
    )


def test_the_page_is_whole_and_shows_the_claims_first(text):
    seen = Page(text)
    assert seen.open == []
    assert len(set(seen.identifiers)) == len(seen.identifiers)
    assert "https://" not in text.partition("<script>")[0]
    places = [
        text.index(each) for each in ('id="chart-spread"', "It is &lt;small&gt;.", "It cannot be seen.", "Words.")
    ]
    assert places == sorted(places)


def test_claims_stand_with_their_figures_and_verdicts(text):
    words = " ".join(" ".join(Page(text).texts).split())
    for said in (
        "It is <small>.",
        "1.5 to 2.2",
        "≤ 0.3",
        "≥ 0.3",
        "0.02",
        "in few drives",
        "The paper: 1 holds",
        "0.55",
    ):
        assert said in words
    assert "1 holds, 2 do not hold, 1 not measured" in words


def test_figures_without_a_goal_stand_apart_and_are_not_counted(text):
    claims, described = text.split("Figures of description</h3>")
    assert "It is as long as it is." not in claims
    assert "7.25" in described.partition("</section>")[0]


def test_groups_without_a_title_stand_last_under_their_name(text):
    assert text.index("The paper:") < text.index("other:")


def test_panels_share_colours_and_the_legend_names_a_mark_once(text):
    data = charts(text)["spread"]["data"]
    bars, _, boxes, points = data
    assert bars["marker"]["color"] == boxes["line"]["color"] != points["marker"]["color"]
    assert [trace["showlegend"] for trace in (bars, boxes)] == [True, False]
    assert boxes["lowerfence"] == [3.0]
    assert points["error_y"]["arrayminus"] == [0.5]


def test_names_on_a_logarithmic_axis_stand_at_their_height(text):
    notes = charts(text)["spread"]["layout"]["annotations"]
    assert [note["y"] for note in notes if note["text"] == "limit"] == [2.0]


def test_a_study_without_charts_needs_no_library():
    assert "Plotly" not in render_study(page(CLAIMS[0]))


def test_a_band_and_a_logarithmic_axis_along():
    panel = Panel(
        "",
        "frequency [Hz]",
        "gain [dB]",
        (
            Lines("measured", [1, 10, 100], [0, -3, -40]),
            Band("measured", [1, 10, 100], [-1, math.nan, -41], [1, math.nan, -39]),
        ),
        uprights=(("corner", 10.0),),
        logarithmic_along=True,
    )
    drawn = charts(render_study(page(Chart("bode", "Bode", "Read.", "Shows.", (panel,)))))["bode"]
    assert drawn["layout"]["xaxis"]["type"] == "log"
    assert drawn["layout"]["annotations"][0]["x"] == 1.0
    line, band = drawn["data"]
    assert band["fillcolor"] == line["line"]["color"]
    assert band["legendgroup"] == "measured"
    assert not band["showlegend"]
    assert None in band["x"]


def test_small_values_along_a_logarithmic_axis_are_kept():
    curve = Lines("curve", [1e-4, 1.0, 1e4], [1.0, 2.0, 3.0])
    figure = panel_figure(Chart("c", "C", "", "", (Panel("", "x", "y", (curve,), logarithmic_along=True),)))
    assert figure.data[0]["x"] == [1e-4, 1.0, 1e4]


def test_cells_are_drawn_from_the_top_with_their_shares_in_them():
    cells = Cells("share", ["yaw rate", "angle"], ["yaw rate", "angle", "torque"], np.array([[1, 0, 0.25], [0, 1, 0]]))
    figure = panel_figure(Chart("named", "Named", "", "", (Panel("", "named", "true", (cells,)),)))
    (drawn,) = figure.data
    assert drawn["type"] == "heatmap"
    assert drawn["z"][0] == [1.0, 0.0, 0.25]
    assert drawn["text"] == [["1", "", "0.25"], ["", "1", ""]]
    assert figure.layout["yaxis"]["autorange"] == "reversed"
    assert figure.summary[0][1:] == ("0", "0.375", "1")


def test_named_rows_stand_in_place_of_numbers_and_need_no_legend():
    flags = Panel("", "time [s]", "flag", (Lines("r1", [0, 1], [0, 1]),), rows=(("r1", 0.5), ("r2", 2.0)))
    figure = panel_figure(Chart("flags", "Flags", "", "", (flags,)))
    up = figure.layout["yaxis"]
    assert (up["tickvals"], up["ticktext"]) == ([0.5, 2.0], ["r1", "r2"])
    assert up["range"][0] < 0.0
    assert up["range"][1] > 2.5
    assert not figure.data[0]["showlegend"]


def test_a_way_is_drawn_to_scale():
    figure = panel_figure(Chart("way", "Way", "", "", (Panel("", "x", "y", (Lines("a", [0], [0]),), to_scale=True),)))
    assert figure.layout["yaxis"]["scaleanchor"] == "x"


def test_points_that_stand_sideways_have_their_ranges_along():
    marks = (Points("effect", ["a", "b"], [1.0, 2.0], [0.5, 1.0], [1.5, 4.0]),)
    (drawn,) = panel_figure(Chart("c", "", "", "", (Panel("", "", "", marks, sideways=True),))).data
    assert drawn["y"] == ["a", "b"]
    assert drawn["error_x"]["array"] == [0.5, 2.0]
    assert "error_y" not in drawn
