import dataclasses

import numpy as np
import pytest

from diagnosis_examples import EXAMPLES, friction_fault, trace
from report_pages import Page, charts, series
from tierod.core.errors import OutputError
from tierod.core.findings import Status
from tierod.core.signals import SIGNALS
from tierod.report import write_html
from tierod.report.charts.over_time import signal_figure
from tierod.report.diagnosis import render
from tierod.report.display import words
from tierod.report.html import breakable


@pytest.fixture(scope="module")
def fault_page():
    return render(friction_fault())


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_page_is_whole_and_needs_no_network(name):
    text = render(EXAMPLES[name]())
    page = Page(text)
    assert page.open == []
    assert len(set(page.identifiers)) == len(page.identifiers)
    for tag, attributes in page.attributes:
        assert "src" not in attributes, f"{tag} loads {attributes['src']}"
        assert not attributes.get("href", "").startswith(("http", "//"))
    assert "@import" not in text.split("</style>")[0]
    assert ("html", {"lang": "en"}) in page.attributes


def test_the_verdict_stands_before_everything_else(fault_page):
    said = " ".join(" ".join(Page(fault_page).texts).split()).partition("What the words mean ")[2]
    order = [
        "fault",
        "change began at 30 min 11 s",
        "rose to three times",
        "12.43 N·m",
        "95 % interval 12.21 to 12.65 N·m",
        "Why:",
        "What to do:",
        "To know:",
    ]
    order += ["Friction over time", "Hysteresis", "Stretch by stretch", "Can the estimator be trusted", "NIS within"]
    order += [
        "What was recorded",
        "Data quality",
        "Parameters and where they come from",
        "tierod diagnose drive.parquet",
    ]
    places = [said.index(each) for each in order]
    assert places == sorted(places)


def test_every_chart_has_a_place_a_sentence_and_a_table(fault_page):
    page = Page(fault_page)
    places = {attributes["id"]: attributes for tag, attributes in page.attributes if attributes.get("class") == "chart"}
    assert set(places) == {f"chart-{name}" for name in charts(fault_page)}
    assert set(charts(fault_page)) == {"estimate-friction", "loops", "histograms", "innovations", "signals"}
    for attributes in places.values():
        assert attributes["role"] == "group"
        assert len(attributes["aria-label"]) > 20
    tables = [attributes["aria-label"] for _, attributes in page.attributes if attributes.get("class") == "wide"]
    assert {"Friction over time", "Stretch by stretch", "Innovations over time", "The drive"} <= set(tables)


def test_levels_truth_and_enabled_stretches_are_drawn(fault_page):
    chart = charts(fault_page)["estimate-friction"]
    names = [series.get("name") for series in chart["data"]]
    assert names == ["95 % interval", "lowest to highest", "estimate", "truth", "enabled share"]
    levels = [shape["y0"] for shape in chart["layout"]["shapes"] if shape.get("xref") == "paper"]
    assert levels == [4.0, 4.05, 4.8, 7.5]
    labels = [note["text"] for note in chart["layout"]["annotations"]]
    assert "nominal 4, learnt level 4.05 N·m" in labels
    assert "change began" in labels


@pytest.mark.parametrize(
    ("origin", "printed"),
    [
        (1533198887.0, "<dt>Began</dt><dd>2018-08-02 08:34:47 UTC</dd>"),
        (0.0, "<dt>Origin</dt><dd>0</dd>"),
        (1e300, "<dt>Origin</dt>"),
        (float("nan"), "<dt>Origin</dt>"),
    ],
)
def test_when_a_recording_began_is_printed_as_a_date(origin, printed):
    made = friction_fault()
    text = render(dataclasses.replace(made, recording={**made.recording, "origin": origin}))
    assert printed in text


def test_a_long_name_of_a_source_breaks_at_its_separators_only(fault_page):
    assert str(breakable("STEER_ANGLE.FRACTION <0.5>")) == "STEER_<wbr>ANGLE.<wbr>FRACTION &lt;0.5&gt;"
    assert "CAN EPS_<wbr>1.<wbr>Angle" in fault_page


def test_a_number_is_not_parted_from_its_unit():
    diagnosis = friction_fault(bins=20)
    finding = dataclasses.replace(diagnosis.findings[0], headline="Friction 12.4 ± 1 N·m, 30 % of 5 drives")
    text = render(dataclasses.replace(diagnosis, findings=(finding,)))
    visible = text.replace("\N{NO-BREAK SPACE}", "_")
    assert "<h1>Friction 12.4_±_1_N·m, 30_% of 5 drives.</h1>" in visible


def test_tuning_is_a_list_with_its_source_reported_once():
    diagnosis = friction_fault(bins=20)
    rows = tuple((f"gate.value_{index}", float(index), "s", None, "tuning of Monitor") for index in range(40))
    text = render(dataclasses.replace(diagnosis, parameters=(*diagnosis.parameters, *rows)))
    said = " ".join(" ".join(Page(text).texts).split())
    assert "Tuning of the monitor (40 values)" in said
    assert said.count("Tuning of Monitor") == 1
    assert "Gate: value 39 39 s" in said


def test_the_part_on_consistency_explains_no_band_where_there_is_none():
    diagnosis = friction_fault(bins=20)
    assert "below it underconfident" in render(diagnosis)
    remarked = dataclasses.replace(diagnosis, remarks={"consistency": "Its variance is set wide."})
    assert "below it underconfident" not in render(remarked)
    assert "Its variance is set wide." in render(remarked)


def test_a_gap_stays_a_gap(fault_page):
    drawn = signal_figure(friction_fault()).data
    yaw = next(mark for mark in drawn if mark.get("name") == "Yaw rate")
    assert None in yaw["y"]
    outline = next(mark for mark in drawn if mark["yaxis"] == yaw["yaxis"] and mark.get("fill") == "toself")
    assert outline["y"].count(None) == 1
    known = np.isfinite(friction_fault().traces["yaw_rate"].mean)
    np.testing.assert_array_equal(np.isfinite(series(fault_page)["yaw_rate"].upper), known)


def test_names_cannot_break_out_of_the_page():
    evil = "</script><script>alert(1)</script>"
    diagnosis = friction_fault(bins=20)
    finding = dataclasses.replace(diagnosis.findings[0], headline=evil, monitor=evil)
    loops = {evil: diagnosis.loops["before"]}
    text = render(
        dataclasses.replace(diagnosis, findings=(finding,), loops=loops, recording={"name": evil}, command=evil)
    )
    assert evil not in text
    assert Page(text).open == []
    assert charts(text)["loops"]["layout"]["annotations"][0]["text"].lower() == evil


def test_merging_hides_no_peak():
    time = np.arange(20_001) * 0.01
    values = np.zeros(20_001)
    values[12_345] = 77.0
    text = render(
        dataclasses.replace(
            friction_fault(bins=30), traces={"driver_torque": trace("driver_torque", "N*m", time, values)}
        )
    )
    assert series(text)["driver_torque"].upper.max() == pytest.approx(77.0)


@pytest.mark.parametrize("status", Status)
def test_every_status_is_reported_in_words_and_by_a_symbol(status):
    finding = dataclasses.replace(friction_fault(bins=20).findings[0], status=status)
    text = render(dataclasses.replace(friction_fault(bins=20), findings=(finding,), traces={}, loops={}, histograms={}))
    assert f">{status}</a></span>" in text
    assert status.symbol in text


def test_an_all_missing_estimate_is_drawn_without_warnings():
    diagnosis = friction_fault(bins=50)
    nothing = np.full(50, np.nan)
    traces = {
        name: trace(name, "N*m", np.arange(50.0), nothing)
        for name in ("friction", "friction_standard_deviation", "enabled")
    }
    text = render(dataclasses.replace(diagnosis, traces=traces, loops={"none": (nothing, nothing)}, histograms={}))
    assert "no value in the whole recording" in text


def test_a_page_that_cannot_be_written_says_so(tmp_path):
    with pytest.raises(OutputError, match="create the folder first"):
        write_html(EXAMPLES["nothing"](), tmp_path / "absent" / "report.html")


def test_a_signal_that_was_not_recorded_gets_no_strip():
    known = friction_fault()
    missing = [name for name in known.traces if name in SIGNALS][-1]
    empty = dict.fromkeys(("lower", "upper", "mean"), np.full(len(known.traces[missing].time), np.nan))
    without = dataclasses.replace(
        known, traces={**known.traces, missing: dataclasses.replace(known.traces[missing], **empty)}
    )
    assert words(missing) in signal_figure(known).alternative
    assert words(missing) not in signal_figure(without).alternative


def test_every_sensor_and_actuator_has_its_line_and_every_episode_too():
    page = Page(render(EXAMPLES["several_elements"]()))
    said = " ".join(" ".join(page.texts).split()).partition("Sensors and actuators")[2]
    order = [
        "Yaw rate",
        "fault",
        "outlier",
        "12 s",
        "12.4 s",
        "positive offset",
        "31.2 s",
        "end",
        "16.62",
        "Tie rod force",
    ]
    place = 0
    for each in order:
        place = said.index(each, place) + len(each)
    assert "not separable from steering motor 2" in said


def test_the_page_ranks_uncertain_parameters_and_calls_an_estimate_by_its_word():
    text = render(EXAMPLES["estimated"]())
    assert ">estimated</a></span>" in text
    assert "healthy" not in text.split("<main>")[1].split("How this page came about")[0]
    assert text.index("Which parameters decide") < text.index("rear_distance</th>") < text.index("steering_ratio</th>")
    assert "Measure rear_distance first" in text
    assert "that of the class &#39;midsize&#39; is assumed" in text or "that of the class 'midsize' is assumed" in text
