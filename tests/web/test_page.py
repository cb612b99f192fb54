"""The page in a browser: every view, wide and narrow, light and dark; nothing serious for axe where it is there."""

import json
import os
import shutil
import threading
import urllib.parse

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


def test_a_report_opens_in_a_frame_of_its_own(page, analysed):
    opened(page, f"/recording?report={analysed.result}/friction", "Report of friction")
    page.frame_locator("iframe.report").locator("h1").wait_for()


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


@pytest.mark.parametrize("name", ["weave.parquet", "a~b*c (1) é+.parquet"])
def test_what_the_view_begins_with_is_asked_for_once(page, name):
    asked = []
    page.on("request", lambda request: asked.append(request.url) if "/api/opened" in request.url else None)
    page.goto("/recording?" + urllib.parse.urlencode({"file": f"drives/{name}"}))
    page.wait_for_selector(".problem, .plot")
    page.wait_for_load_state("networkidle")
    assert len(asked) == 1
    page.slips.clear()  # the browser names the 404 itself


def test_what_is_missing_is_a_sentence(page):
    page.goto("/recording?file=drives/gone.parquet")
    page.get_by_role("alert").wait_for()
    assert "reload" in page.get_by_role("alert").inner_text()
    assert page.locator(".loading").count() == 0
    page.slips.clear()  # the browser names the 404 itself


def test_curves_follow_the_theme(page):
    opened(page, f"/recording?file={FILE}&signals=driver_torque", "Driver torque [N·m]")
    charts(page, 1)
    curve = "() => getComputedStyle(document.querySelector('.panel .chip i')).backgroundColor"
    drawn = """(colour) => {
        const canvas = document.querySelector('.panel canvas'), wanted = colour.match(/\\d+/g).slice(0, 3).map(Number);
        const all = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
        for (let at = 0; at < all.length; at += 4) if (wanted.every((each, k) => each === all[at + k])) return true;
        return false;
    }"""
    for scheme, button in (("light", "Light"), ("dark", "Dark")):
        page.emulate_media(color_scheme=scheme)
        page.get_by_role("button", name=button, exact=True).wait_for()
        page.wait_for_function(drawn, arg=page.evaluate(curve))


def test_a_recording_of_one_sample_without_verdict_says_why(page, tmp_path):
    path = tmp_path / "instant.csv"
    path.write_text("time,yaw_rate\n0,0\n", encoding="utf-8")
    opened(page, "/new", "Upload a recording")
    page.locator("input[type=file]").set_input_files(path)
    page.get_by_role("heading", name="New recording").wait_for()
    page.goto("/recording?file=uploads/instant.csv")
    page.get_by_role("heading", name="Verdicts").wait_for()
    charts(page, 1)
    assert page.locator(".problem").count() == 0
    page.get_by_text("which the recording does not have").first.wait_for()
    page.get_by_role("link", name="Correct the channel map").click()
    page.get_by_role("heading", name="Channel map").wait_for()


def test_a_bus_that_cannot_be_followed_says_why(page):
    def with_bus(route):
        answer = route.fetch()
        route.fulfill(response=answer, json={**answer.json(), "live": ["virtual:1"]})

    said = json.dumps({"event": "problem", "schema": 1, "text": "the vehicle names no CAN database"})
    page.route("**/api/site", with_bus)
    page.route_web_socket("**/api/live", lambda socket: socket.send(said))
    page.goto("/live")
    assert page.get_by_role("alert").inner_text() == "The vehicle names no CAN database."
    assert page.get_by_text("No samples yet").count() == 0
    page.get_by_text("No signals yet").wait_for()


def test_units_in_doubt_are_named_once_and_lead_to_the_channel_map(page, tmp_path):
    path = tmp_path / "degrees.csv"
    signs = [(n, (-1) ** (n // 100)) for n in range(900)]
    rows = [f"{0.01 * n:.2f},{400 * sign},{20 + 0.01 * n:.2f},{15 * sign}" for n, sign in signs]
    path.write_text("time,steering_wheel_angle,vehicle_speed,yaw_rate\n" + "\n".join(rows), encoding="utf-8")
    opened(page, "/new", "Upload a recording")
    page.locator("input[type=file]").set_input_files(path)
    page.get_by_role("heading", name="Channel map").wait_for()
    page.goto("/recording?file=uploads/degrees.csv")
    page.get_by_role("heading", name="Verdicts").wait_for()
    assert page.get_by_text("steering wheel angle was taken as rad and looks like deg").count() == 1
    assert page.get_by_text("has no unit in the file").count() == 0
    page.set_viewport_size({"width": 420, "height": 850})
    page.get_by_role("link", name="Correct the units").click()
    page.get_by_role("heading", name="Channel map").wait_for()
    field = page.get_by_label("column of steering_wheel_angle").bounding_box()
    assert field["x"] + field["width"] <= 420


def test_a_bin_before_a_pause_is_not_drawn_into_it(page, tmp_path):
    from live_drives import drive
    from tierod.core.recording import Channel, Recording
    from tierod.io.writers import write

    whole = drive(120.0)["yaw_rate"]
    kept = (whole.time < 40.0) | (whole.time > 80.0)
    broken = Channel("yaw_rate", whole.time[kept], whole.values[kept], whole.unit)
    write(Recording({"yaw_rate": broken}), tmp_path / "pause.parquet")
    opened(page, "/new", "Upload a recording")
    page.locator("input[type=file]").set_input_files(tmp_path / "pause.parquet")
    page.get_by_role("heading", name="Channel map").wait_for()
    page.goto("/recording?file=uploads/pause.parquet&signals=yaw_rate")
    page.get_by_role("heading", name="Verdicts").wait_for()
    charts(page, 1)
    filled = """([from, to]) => {
        const canvas = document.querySelector('.panel canvas'), area = document.querySelector('.panel .u-over');
        const wanted = getComputedStyle(document.querySelector('.panel .chip i')).backgroundColor.match(/\\d+/g);
        const x = (share) => devicePixelRatio * (area.offsetLeft + share * area.offsetWidth);
        const all = canvas.getContext('2d').getImageData(x(from), 0, x(to) - x(from), canvas.height).data;
        for (let at = 0; at < all.length; at += 4) if ([0, 1, 2].every((k) => +wanted[k] === all[at + k])) return true;
        return false;
    }"""
    page.wait_for_function(filled, arg=[0.05, 0.3])
    assert not page.evaluate(filled, [0.35, 0.65])
