"""A diagnosis as a page, as a document and in the terminal: the same words and figures, in usual units."""

import dataclasses
import io
import json
import math
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from rich.console import Console

import tierod.report
from diagnosis_examples import EXAMPLES, friction_fault
from report_pages import Page, charts, series
from tierod.core.findings import Estimate
from tierod.report import print_table, to_json
from tierod.report.charts.over_time import signal_figure
from tierod.report.diagnosis import render
from tierod.report.display import duration, interval, number
from tierod.report.document import SCHEMA, plain
from tierod.report.html import TEMPLATES


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


SHIPPED = json.loads((Path(tierod.report.__file__).parent / "diagnosis.schema.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", EXAMPLES)
@pytest.mark.parametrize("series", [False, True])
def test_every_document_keeps_to_the_shipped_schema(name, series):
    document = json.loads(to_json(EXAMPLES[name](), series))
    jsonschema.validate(document, SHIPPED, jsonschema.Draft202012Validator)
    assert document["schema"] == SCHEMA
    order = list(document)
    assert order.index("status") < order.index("findings") < order.index("elements") < order.index("quality")
    assert order[-1] == "recording", "of a simulation it holds every parameter of the plant"


def test_what_cannot_be_said_is_null():
    assert plain({"a": float("nan"), "b": (np.inf, 1)}) == {"a": None, "b": [None, 1]}
    assert plain(np.array([1.0, np.nan])) == [1.0, None]
    assert plain([np.int64(3), np.float32(0.5), np.bool_(True), Path("x"), None]) == [3, 0.5, True, "x", None]


def test_the_decisive_finding_decides_status_and_exit_code():
    document = json.loads(to_json(friction_fault()))
    assert (document["status"], document["exit_code"]) == ("fault", 1)
    assert document["findings"][0]["estimate"]["interval"] == pytest.approx([12.2144, 12.6456])
    assert json.loads(to_json(EXAMPLES["nothing"]()))["exit_code"] == 2


def printed(name):
    console = Console(file=io.StringIO(), width=200)
    print_table(EXAMPLES[name](), console)
    return console.file.getvalue()


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (
            "friction_fault",
            [
                "✕ FAULT",
                "12.43 N·m  (95 %: 12.21 to 12.65)",
                "fault level 7.5 N·m",
                "21 min 50 s",
                "Remarks on the data",
            ],
        ),
        ("healthy", ["✓ HEALTHY", "as it should be"]),
        ("not_identifiable", ["? NOT IDENTIFIABLE", "<lane keeping> was active", "what to do", "raw counts"]),
        (
            "several_elements",
            [
                "Sensors and actuators",
                "✕ FAULT",
                "outlier",
                "positive offset",
                "16.62 °/s (16.17 to 17.06)",
                "angle and speed (0.008 rad/s)",
                "C1A33-64",
                "kind not known; not separable from steering motor 2",
                "the recording has no tie_rod_force",
            ],
        ),
        (
            "estimated",
            [
                "≈ ESTIMATED",
                "Which parameters decide",
                "rear_distance",
                "1.2 ± 0.3 m",
                "+3.5 °",
                "99 %",
                "−0.11 °",
                "Measure rear_distance first",
                "that of the class 'midsize' is assumed",
            ],
        ),
        ("nothing", ["? NOT AVAILABLE  no monitor ran"]),
    ],
)
def test_says_what_was_found(name, expected):
    text = printed(name)
    for each in expected:
        assert each in text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (4.0, "4"),
        (-0.0, "0"),
        (0.00123456, "0.001235"),
        (123456.0, "123500"),
        (1e-7, "1.000e−07"),
        (float("nan"), "–"),
        (None, "–"),
    ],
)
def test_numbers_keep_their_significant_digits(value, text):
    assert number(value) == text


@pytest.mark.parametrize(("seconds", "text"), [(0.0, "0 s"), (60.0, "1 min"), (1811.0, "30 min 11 s"), (None, "–")])
def test_durations_read_like_a_clock(seconds, text):
    assert duration(seconds) == text


@pytest.mark.parametrize(
    ("value", "spread", "expected"),
    [
        (12.43, 0.11, ("12.43", "12.21", "12.65", "N·m")),
        (-0.001, 1.0, ("0.0", "−2.0", "2.0", "N·m")),
        (400.0, 100.0, ("400", "204", "596", "N·m")),
        (4.0, math.nan, ("4.00", "–", "–", "N·m")),
        (math.nan, 0.1, ("–", "–", "–", "N·m")),
    ],
)
def test_an_estimate_is_rounded_by_its_own_uncertainty(value, spread, expected):
    assert interval(Estimate("friction", value, spread, "N*m")) == expected


def estimate(value=12.4, spread=0.1, **reference):
    return Estimate("friction", value, spread, "N*m", reference)


TOKENS = (TEMPLATES / "tokens.css").read_text(encoding="utf-8")
COLOURS = {
    name: {"light": light, "dark": dark}
    for name, light, dark in re.findall(r"(--[a-z-]+): var\(--light, (#\w{6})\) var\(--dark, (#\w{6})\);", TOKENS)
}
TEXT = [
    *((f"--{name}", ground) for name in ("ink", "muted", "accent") for ground in ("--paper", "--ground")),
    *((f"--{kind}", ground) for kind in ("good", "warn", "bad", "open") for ground in ("--paper", f"--{kind}-tint")),
    *(("--on-kind", f"--{kind}") for kind in ("good", "warn", "bad", "open")),
    *(("--ink", f"--{kind}-tint") for kind in ("good", "warn", "bad", "open")),
]


def luminance(colour):
    parts = (int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5))
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize(("text", "ground"), TEXT)
def test_text_can_be_read_on_its_ground(text, ground, theme):
    """Contrast of at least 4.5 to 1, as WCAG 2.1 asks for (1.4.3)."""
    low, high = sorted(luminance(COLOURS[name][theme]) for name in (text, ground))
    assert (high + 0.05) / (low + 0.05) >= 4.5


def test_every_colour_that_is_named_is_in_the_style():
    known = set(re.findall(r"^  (--[a-z-]+):", TOKENS, re.MULTILINE)) | {"--kind", "--tint", "--light", "--dark"}
    places = [*TEMPLATES.parent.rglob("*.py"), *TEMPLATES.glob("*.css"), *TEMPLATES.glob("*.js")]
    named = {name for path in places for name in re.findall(r"var\((--[a-z-]+)", path.read_text(encoding="utf-8"))}
    assert len(named) > 20
    assert named <= known
