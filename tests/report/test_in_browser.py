"""Pages in a headless browser: charts, colours, cursor, explanations, data, folds, width, and what axe-core finds."""

import numpy as np
import pytest

from browser import NARROW, WIDE, chromium, violations
from diagnosis_examples import EXAMPLES, friction_fault
from report.test_charts import CHART, CLAIMS
from report.test_charts import page as study
from tierod.core.content import Chart, Heading, Lines, Panel, Table
from tierod.fleet.report import worked_out
from tierod.fleet.report_page import render as fleet
from tierod.fleet.schema import findings, ledger
from tierod.fleet.trends import Design
from tierod.report.diagnosis import render
from tierod.report.html import Analysis, Origin, render_analysis
from tierod_lab.studies.page import render_study


def many_charts():
    curve = Lines("curve", [0, 1, 2], [1.0, 4.0, 9.0])
    items = [Heading("Curves", ("Words.",))]
    items += [
        Chart(f"c{n}", f"Chart {n}", "Read.", "Shows.", (Panel("", "x [m]", "y [N]", (curve,)),)) for n in range(11)
    ]
    return Analysis("Many charts", ("Summary.",), [*items, Table("T", ("what", "value"), (("Yaw rate", "1"),))], {})


PAGES = {
    **{name: lambda name=name: render(EXAMPLES[name]()) for name in EXAMPLES},
    "study": lambda: render_study(study(*CLAIMS, Heading("Spread", ("Words.",)), CHART)),
    "analysis": lambda: render_analysis(many_charts(), [("vehicle", "midsize-eps")], Origin.now("tierod analyse")),
    "fleet": lambda: fleet(worked_out(findings().empty_table(), ledger().empty_table(), Design())),
}


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


@pytest.fixture
def opened(browser, tmp_path):
    """Opens a page and gives it with what went wrong in it."""
    contexts = []

    def opens(content, size=WIDE, theme="light", **more):
        path = tmp_path / "page.html"
        path.write_text(content, encoding="utf-8")
        context = browser.new_context(viewport=size, color_scheme=theme, **more)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: pytest.fail(str(error)))
        page.goto(path.as_uri())
        drawn = "[...document.querySelectorAll('.chart')].every(c => c.closest('details:not([open])') || c.data)"
        page.wait_for_function(drawn)
        return page

    yield opens
    for each in contexts:
        each.close()


@pytest.mark.parametrize("name", PAGES)
@pytest.mark.parametrize(("size", "theme"), [(WIDE, "light"), (NARROW, "dark")])
def test_every_page_is_accessible_and_fits_its_screen(opened, name, size, theme):
    page = opened(PAGES[name](), size, theme)
    assert page.evaluate("document.documentElement.scrollWidth - window.innerWidth") <= 0
    assert violations(page) == []


def test_charts_are_dark_where_the_reader_asks_for_it_and_light_in_print(opened):
    page = opened(render(friction_fault()), theme="dark")
    ground = "document.querySelector('.chart').layout.paper_bgcolor"
    dark = page.evaluate(ground)
    assert page.evaluate("getComputedStyle(document.querySelector('section')).backgroundColor") != "rgb(255, 255, 255)"
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert page.evaluate(ground) == "#ffffff" != dark
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert page.evaluate(ground) == dark
    page.emulate_media(color_scheme="light")
    page.wait_for_function(f"{ground} === '#ffffff'")
    assert "var(" not in page.evaluate("JSON.stringify([...document.querySelectorAll('.chart')].map(c => c.layout))")


def test_a_key_moves_one_cursor_through_all_charts_over_time(opened):
    page = opened(render(friction_fault()))
    page.locator("#chart-estimate-friction").focus()
    page.keyboard.press("ArrowRight")
    lines = page.locator(".cursor")
    page.wait_for_function("[...document.querySelectorAll('.cursor')].every(line => !line.hidden)")
    first = [line["x"] for line in (each.bounding_box() for each in lines.all()) if line]
    page.keyboard.press("Shift+ArrowRight")
    page.wait_for_timeout(100)
    second = [line["x"] for line in (each.bounding_box() for each in lines.all()) if line]
    assert len(first) == 3
    assert max(first) - min(first) < 2.0
    assert np.min(np.subtract(second, first)) > 20.0
    page.keyboard.press("Escape")
    page.wait_for_function("[...document.querySelectorAll('.cursor')].every(line => line.hidden)")


def test_the_explanation_of_a_word_appears_on_focus_hover_and_touch(opened):
    page = opened(render(friction_fault()))
    term = page.locator("main a.term:visible", has_text="Mass").first
    term.scroll_into_view_if_needed()
    term.hover()
    tip = page.locator(".tip")
    assert "Mass of the vehicle as driven" in tip.inner_text()
    page.keyboard.press("Escape")
    assert tip.is_hidden()
    page.locator("main a.info:visible").first.focus()
    assert "95 % interval" in tip.inner_text()
    touch = opened(render(friction_fault()), NARROW, has_touch=True, is_mobile=True)
    touch.locator("main a.info:visible").first.tap()
    assert touch.locator(".tip").is_visible()
    assert "#" not in touch.url
