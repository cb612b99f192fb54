"""Charts and series of the pages of diagnoses, studies and campaigns."""

import json
import math
import re
import shutil
import subprocess

import numpy as np
import pytest

import report_pages
from diagnosis_examples import friction_fault
from experiments.test_summary import ROWS, gate, summary
from report_pages import Page
from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Bars, Boxes, Chart, Heading, Lines, Panel, Points, Table
from tierod.core.findings import Diagnosis, Element, Episode, Estimate, Finding, Status, Trace
from tierod.report import write_html
from tierod.report.charts.elements import substitute_figures
from tierod.report.charts.over_time import estimate_figures, signal_figure
from tierod.report.html import TEMPLATES, heads, packed_series
from tierod_lab.campaign.report import render_campaign
from tierod_lab.campaign.summary import document, text
from tierod_lab.studies.page import StudyPage, render_study

SECONDS = np.arange(100) * 0.1


def level_trace(name, unit, values):
    values = np.broadcast_to(np.asarray(values, float), SECONDS.shape)
    return Trace(name, unit, SECONDS, values, values, values)


def with_elements():
    states = np.where((SECONDS > 3.0) & (SECONDS < 6.0), 1.0, 0.25)
    states[-10:] = np.nan
    traces = [
        level_trace("yaw_rate", "rad/s", 1.0),
        level_trace("state_of_yaw_rate", "", states),
        level_trace("state_of_drive_left", "", 0.0),
        level_trace("supplied_yaw_rate", "rad/s", 0.5),
        level_trace("deviation_of_supplied_yaw_rate", "rad/s", 0.1),
    ]
    size = Estimate("offset of yaw rate", 0.5, 0.01, "rad/s")
    elements = (
        Element("yaw_rate", "sensor", Status.FAULT, "", (Episode("offset", 3.0, 6.0, size),), "filter", "C1A32-64"),
        Element("drive_left", "actuator", Status.HEALTHY),
    )
    finding = Finding("condition, bank", Status.FAULT, "Yaw rate sensor: positive offset.")
    return Diagnosis((finding,), elements, {each.name: each for each in traces})


def test_a_replaced_sensor_shows_reading_substitute_and_band_in_usual_units():
    (figure,) = substitute_figures(with_elements())
    lines = {each["name"]: each for each in figure.data}
    assert lines["reading"]["y"][0] == pytest.approx(57.296, rel=1e-4)
    assert lines["supplied"]["y"][0] == pytest.approx(28.648, rel=1e-4)
    assert max(lines["95 % interval"]["y"]) == pytest.approx(np.degrees(0.5 + 0.196), rel=1e-4)
    assert figure.layout["annotations"][0]["text"] == "offset"
    assert (figure.layout["shapes"][0]["x0"], figure.layout["shapes"][0]["x1"]) == (3.0, 6.0)
    assert "°/s" in figure.layout["yaxis"]["title"]["text"]
    assert "filter" in figure.caption


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
            "Lower", "state", "friction [N·m]",
            (Boxes.normal("healthy", ["H"], [4.0], [0.5]), Points("truth", ["H"], [4.0], [3.5], [4.5])),
            levels=(("limit", 100.0),), uprights=(("here", 1.0),), logarithmic=True,
        ),
    ),
)  # fmt: skip


def page(*items):
    return StudyPage("one", "One study", "What it is about.", {"paper": "The paper"}, items)


def test_claims_stand_with_their_figures_and_verdicts():
    items = (*CLAIMS[:3], Heading("Spread", ("Words.",)), CHART, *CLAIMS[3:], Table("T", ("a",), (("1",),)))
    words = " ".join(" ".join(Page(render_study(page(*items))).texts).split())
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


EVIL = "<script>alert(1)</script>"


def content(rows=ROWS, gates=()):
    return json.loads(text(document(summary(rows, gates), f"tierod campaign {EVIL}")))


def test_the_page_of_a_campaign_shows_gates_matrix_states_and_failures():
    gates = [gate("detection_worst_s", "<= 10"), gate("false_alarms", "<= 9", fault="fault-free")]
    page = render_campaign(json.loads(text(document(summary(gates=gates), "tierod campaign <script>alert(1)"))))
    assert "A pass criterion is missed" in page
    assert re.search(r"detection_worst_s</th><td[^>]*>all drives</td>.*?≤ 10</td><td[^>]*>never</td>", page)
    for said in ("1 false alarm", "1 diverged", "gone", "State given, verdict found", "&lt;script&gt;alert(1)"):
        assert said in page


DRAWN = """
const fs = require("fs");
const { script, heads, marks, view } = JSON.parse(fs.readFileSync(0));
const series = eval(script + "; series");
series.store(heads).then((store) => console.log(JSON.stringify(marks.map((meta) => series.drawn(store, meta, view)))));
"""


def test_an_hour_stays_below_two_megabytes(tmp_path):
    path = write_html(friction_fault(duration=3600.0, bins=45_000), tmp_path / "report.html")
    assert path.stat().st_size < 2e6
    finest = report_pages.series(path.read_text(encoding="utf-8"))["yaw_rate"]
    assert np.sum((finest.time >= 1800.0) & (finest.time < 1810.0)) > 30


def as_drawn(diagnosis, marks, view=None):
    """Points of marks as the script of the page makes them from the packed series."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    names = set(diagnosis.traces)
    content = {
        "script": (TEMPLATES / "series.js").read_text(encoding="utf-8"),
        "heads": heads(packed_series(diagnosis.traces, names)),
        "marks": [mark["meta"] for mark in marks],
        "view": view,
    }
    done = subprocess.run([node, "-e", DRAWN], input=json.dumps(content), capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def numbers(values):
    return np.array([np.nan if value is None else value for value in values], float)


def test_the_page_draws_what_python_draws():
    diagnosis = friction_fault(bins=1500)
    marks = [*estimate_figures(diagnosis)[0].data, *signal_figure(diagnosis).data]
    marks = [mark for mark in marks if "meta" in mark]
    assert {mark["meta"]["part"] for mark in marks} == {"mean", "range", "interval"}
    for mark, drawn in zip(marks, as_drawn(diagnosis, marks), strict=True):
        size = np.nanmax(np.abs(numbers(mark["y"])))
        np.testing.assert_allclose(numbers(drawn["x"]), numbers(mark["x"]), atol=1e-4)
        np.testing.assert_allclose(numbers(drawn["y"]), numbers(mark["y"]), atol=2e-3 * size)


def test_a_part_of_the_drive_is_drawn_finer_than_the_whole():
    diagnosis = friction_fault(duration=3600.0, bins=45_000)
    marks = [mark for mark in signal_figure(diagnosis).data if mark.get("name") == "Yaw rate"]
    (whole,), (part,) = as_drawn(diagnosis, marks), as_drawn(diagnosis, marks, {"from": 600.0, "to": 610.0})

    def between(drawn, first, last):
        time = numbers(drawn["x"]) / marks[0]["meta"]["per_second"]
        return int(np.sum((time >= first) & (time < last))), time

    assert between(whole, 600.0, 610.0)[0] < 10
    count, time = between(part, 600.0, 610.0)
    assert count > 30
    assert np.all(np.diff(time) > 0.0)
    assert between(part, 2000.0, 3000.0)[0] == between(whole, 2000.0, 3000.0)[0]
    assert max(len(drawn["x"]) for drawn in (whole, part)) < 6000
