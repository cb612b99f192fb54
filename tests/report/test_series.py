"""The time series in a page: small enough, as fine as the room allows, and drawn by the page as Python draws them."""

import gzip
import json
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import report_pages
from diagnosis_examples import friction_fault
from tierod.core.findings import Trace
from tierod.report import write_html
from tierod.report.charts.over_time import estimate_figures, signal_figure
from tierod.report.diagnosis import render
from tierod.report.html import BUDGET, LEAST, LIBRARY, TEMPLATES, heads, packed_series, script_json

DRAWN = """
const fs = require("fs");
const { script, heads, marks, view } = JSON.parse(fs.readFileSync(0));
const series = eval(script + "; series");
series.store(heads).then((store) => console.log(JSON.stringify(marks.map((meta) => series.drawn(store, meta, view)))));
"""


def noisy(names, bins, seed=0):
    """Traces of an hour that hold nothing but noise."""
    rng = np.random.default_rng(seed)
    found = {}
    for name in names:
        mean = rng.normal(size=bins)
        found[name] = Trace(name, "", 3600.0 / bins * np.arange(bins), mean - rng.random(bins), mean + 1.0, mean)
    return found


def test_an_hour_stays_below_two_megabytes(tmp_path):
    path = write_html(friction_fault(duration=3600.0, bins=45_000), tmp_path / "report.html")
    assert path.stat().st_size < 2e6
    finest = report_pages.series(path.read_text(encoding="utf-8"))["yaw_rate"]
    assert np.sum((finest.time >= 1800.0) & (finest.time < 1810.0)) > 30


def test_the_largest_series_give_way_first():
    traces = noisy([f"x{place}" for place in range(40)], 20_000)
    traces["quiet"] = Trace("quiet", "", traces["x0"].time, *3 * (np.zeros(20_000),))
    packed = packed_series(traces, traces)
    assert len(script_json(heads(packed))) < 1.1 * BUDGET
    assert packed["quiet"].count == 20_000
    assert LEAST <= max(each.count for name, each in packed.items() if name != "quiet") < 20_000


def test_no_series_becomes_coarser_than_the_overview():
    packed = packed_series(noisy(["a", "b"], 9000), ["a", "b"], budget=10)
    assert all(LEAST / 2 < each.count <= LEAST for each in packed.values())


def test_what_cannot_be_packed_keeps_its_points():
    diagnosis = friction_fault(bins=50)
    time = np.arange(50.0)
    time[7:] += 1.0
    traces = {**diagnosis.traces, "yaw_rate": replace(diagnosis.traces["yaw_rate"], time=time)}
    text = render(replace(diagnosis, traces=traces))
    assert "yaw_rate" not in report_pages.series(text)
    assert "vehicle_speed" in report_pages.series(text)
    marks = {mark.get("name"): mark for mark in report_pages.charts(text)["signals"]["data"]}
    assert len(marks["Yaw rate"]["x"]) == 50
    assert "x" not in marks["Vehicle speed"]


def test_the_library_is_whole_and_has_all_that_pages_draw_with():
    source = gzip.decompress((TEMPLATES.parent / "library" / LIBRARY).read_bytes()).decode("utf-8")
    assert "plotly.js (cartesian - minified)" in source[:100]
    used = set()
    for path in TEMPLATES.parent.rglob("*.py"):
        used |= set(
            re.findall(r'"type": "(scatter\w*|bar|box|heatmap\w*|pie|contour|violin|histogram\w*)"', path.read_text())
        )
    assert used == {"scatter", "bar", "box", "heatmap"}
    for kind in used:
        assert f'name:"{kind}"' in source or f'moduleType:"trace",name:"{kind}"' in source


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
