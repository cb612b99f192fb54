"""The page in a browser: every view, wide and narrow, light and dark; nothing serious for axe where it is there."""

import os
import shutil
import threading

import pytest

from browser import violations
from tierod.core.statuses import SEVERITY

pytest.importorskip("fastapi", reason="the extra 'web' is not installed")
playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")

CHROMIUM = shutil.which("chromium") or "/usr/bin/chromium"
pytestmark = pytest.mark.skipif(not os.path.exists(CHROMIUM), reason="no chromium is installed")

FILE = "drives/weave.parquet"


@pytest.fixture(scope="module")
def server(analysed, tmp_path_factory):
    import uvicorn

    from tierod.web.app import application
    from tierod.web.guard import Trust
    from tierod.web.server import listening
    from tierod.web.site import Site, roots_of
    from tierod.web.workbench import Workbench
    from tierod_lab.fleet.virtual import FleetFile, drawn
    from tierod_lab.fleet.writing import shipped_law, write_estimates

    top = tmp_path_factory.mktemp("page")
    write_estimates(drawn(FleetFile("small", cars=12, start="2024-01-08", weeks=20)), top / "fleet", shipped_law())
    cache = top / "cache"
    shutil.copytree(analysed.cache, cache)
    recordings, results = roots_of([analysed.folder, top / "fleet"])
    with listening("127.0.0.1", 0) as made, Workbench(Site(recordings, results, cache, "midsize-eps")) as bench:
        port = made.getsockname()[1]
        running = uvicorn.Server(uvicorn.Config(application(bench, Trust(port)), log_level="error"))
        thread = threading.Thread(target=running.run, kwargs={"sockets": [made]}, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{port}"
        running.should_exit = True
        thread.join(timeout=10.0)


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as started:
        made = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield made
        made.close()


@pytest.fixture
def page(browser, server):
    context = browser.new_context(viewport={"width": 1300, "height": 850}, base_url=server)
    made = context.new_page()
    made.set_default_timeout(60_000)  # a machine may be busy
    made.slips = []
    made.on("pageerror", lambda error: made.slips.append(str(error)))
    made.on("console", lambda said: made.slips.append(said.text) if said.type == "error" else None)
    yield made
    assert made.slips == []
    context.close()


VIEWS = {
    "/": "weave.parquet",
    f"/recording?file={FILE}": "Findings over time",
    "/fleet": "Worst first",
    "/vehicle?results=fleet&car=car-01": "Drives (",
    "/new": "Upload a recording",
    f"/recording?file={FILE}&a=10&b=20": "Measured",
    "/scenario": "Drive a virtual car",
    "/live": "No bus is followed",
    "/jobs": "Work",
    "/interface": "/api/series/{key}/window",
}


def opened(page, address, text):
    """Go to a view, and wait until nothing on it moves any more: all that it fetches is there, and all charts drawn."""
    if address == "/":
        address = "/?folder=drives"
    page.goto(address)
    page.get_by_text(text).first.wait_for()
    if address.startswith("/recording?file"):
        page.get_by_text("Findings over time").wait_for()
        page.get_by_role("heading", name="Verdicts").wait_for()
    page.wait_for_function("() => document.querySelector('h1') && !document.querySelector('.loading')")
    page.wait_for_load_state("networkidle")


def charts(page, count):
    """Wait until so many charts are drawn."""
    page.wait_for_function(f"() => document.querySelectorAll('.panel .uplot').length === {count}")


def test_every_status_has_the_word_symbol_and_colour_of_the_report(page):
    def with_every_status(route):
        content = route.fetch().json()
        friction = content["result"]["monitors"]["friction"]
        friction["findings"] = [{**friction["findings"][0], **status.document()} for status in SEVERITY]
        content["result"]["monitors"] = {"friction": friction}
        route.fulfill(json=content)

    page.route("**/api/opened*", with_every_status)
    opened(page, f"/recording?file={FILE}", "Findings over time")
    shown = page.evaluate(
        """() => [...document.querySelectorAll(".finding")].map((each) => [each.className,
        each.querySelector(".badge").className, each.querySelector(".badge").textContent])"""
    )
    assert shown == [[f"finding {each.colour}", f"badge {each.colour}", f"{each.symbol} {each}"] for each in SEVERITY]


@pytest.mark.parametrize("address", VIEWS)
def test_every_view_fits_wide_and_narrow_in_light_and_dark(page, address):
    opened(page, address, VIEWS[address])
    for width in (1300, 420):
        for scheme in ("light", "dark"):
            page.set_viewport_size({"width": width, "height": 850})
            page.emulate_media(color_scheme=scheme)
            assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
            ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
            assert (max(map(int, ground[4:-1].split(","))) < 64) == (scheme == "dark")
    assert page.locator("h1").count() == 1


@pytest.mark.parametrize("address", VIEWS)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(browser, server, address, scheme):
    context = browser.new_context(base_url=server, bypass_csp=True, color_scheme=scheme)
    page = context.new_page()
    opened(page, address, VIEWS[address])
    assert [each for each in violations(page) if each[1] in ("serious", "critical")] == []
    context.close()


def test_the_address_is_the_view(page, browser, server):
    opened(page, f"/recording?file={FILE}&signals=driver_torque;yaw_rate&from=10&to=20", "Driver torque [N·m]")
    charts(page, 2)
    chart = page.locator(".panel .plot").first
    chart.focus()
    page.keyboard.press("+")
    page.wait_for_function("() => +new URLSearchParams(location.search).get('from') > 11")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("a")
    page.get_by_role("heading", name="Measured").wait_for()
    other = browser.new_context(base_url=server).new_page()
    other.goto(page.url)
    other.get_by_role("heading", name="Measured").wait_for()
    charts(other, 2)
    other.context.close()


def test_signals_are_searched_added_overlaid_and_removed(page):
    opened(page, f"/recording?file={FILE}&signals=driver_torque", "Driver torque [N·m]")
    page.get_by_label("Search signals").fill("yaw")
    page.locator(".tree .signal", has_text="Yaw rate").first.click()
    charts(page, 2)
    page.get_by_label("Overlay on the panel above").click()
    charts(page, 1)
    page.wait_for_function("() => location.search.includes('driver_torque,yaw_rate')")
    page.get_by_label("Remove Driver torque").click()
    page.wait_for_function("() => !location.search.includes('driver_torque')")


def test_dragging_zooms_all_charts_and_the_wheel_goes_on(page):
    opened(page, f"/recording?file={FILE}&signals=driver_torque;yaw_rate", "Yaw rate [°/s]")
    charts(page, 2)
    box = page.locator(".u-over").first.bounding_box()
    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 40, steps=4)
    page.mouse.up()
    page.wait_for_function("() => new URLSearchParams(location.search).has('to')")
    low, high = (float(page.evaluate(f"new URLSearchParams(location.search).get('{each}')")) for each in ("from", "to"))
    assert low == pytest.approx(10.0, abs=0.5)
    assert high == pytest.approx(20.0, abs=0.5)
    page.mouse.wheel(0, -200)
    page.wait_for_function(f"() => +new URLSearchParams(location.search).get('to') < {high}")


def test_an_upload_is_mapped_and_inspected(page, tmp_path):
    from live_drives import drive
    from tierod.io.writers import write

    path = tmp_path / "foreign.csv"
    write(drive(12.0), path)
    opened(page, "/new", "Upload a recording")
    page.locator("input[type=file]").set_input_files(path)
    page.get_by_role("heading", name="Channel map").wait_for()
    page.get_by_role("button", name="What can run?").click()
    page.get_by_role("heading", name="What can run").wait_for()
    page.get_by_text("✓ can run").first.wait_for()


def test_the_fleet_is_filtered_and_leads_to_a_car(page):
    opened(page, "/fleet", "Worst first")
    page.get_by_label("search").fill("car-03")
    page.wait_for_function("() => document.querySelectorAll('tbody tr').length === 1")
    page.get_by_role("link", name="car-03").click()
    page.get_by_role("heading", name="Vehicle car-03").wait_for()
    page.locator(".uplot").first.wait_for()


def test_what_is_missing_is_a_sentence(page):
    page.goto("/recording?file=drives/gone.parquet")
    page.get_by_role("alert").wait_for()
    assert "reload" in page.get_by_role("alert").inner_text()
    assert page.locator(".loading").count() == 0
    page.slips.clear()  # the browser names the 404 itself
