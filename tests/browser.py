"""A headless browser for tests of pages; what it needs is no dependency, so that its absence skips them."""

import os
import shutil
from contextlib import contextmanager
from pathlib import Path

import pytest

WIDE, NARROW = {"width": 1400, "height": 900}, {"width": 420, "height": 860}


@contextmanager
def chromium():
    """A browser; skips the test, with the reason, where there is none."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        pytest.skip("chromium is not installed (apt-get install chromium)")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=path, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


PLACES = (os.environ.get("TIEROD_AXE", ""), str(Path(__file__).parents[1] / ".venv" / "axe.min.js"))
"""Of npm's axe-core, which is not part of the project: `bash scripts/axe.sh` fetches it, or TIEROD_AXE names it."""


def violations(page):
    """Rules of axe-core that a page breaks, with the first element each; skips the test where axe-core is not here."""
    axe = next((Path(each) for each in PLACES if each and Path(each).is_file()), None)
    if axe is None:
        pytest.skip("axe-core is not there; `bash scripts/axe.sh` fetches it")
    page.evaluate(axe.read_text(encoding="utf-8"))
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")["violations"]
    return [
        (each["id"], each["impact"], each["nodes"][0]["target"], each["nodes"][0]["failureSummary"]) for each in found
    ]
