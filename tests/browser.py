"""A headless browser for tests of pages; what it needs is no dependency, so that its absence skips them."""

import os
import shutil
import subprocess
from contextlib import contextmanager
from functools import cache
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


@cache
def _axe():
    """Where axe-core is: AXE_CORE names axe.min.js, or npm has it."""
    named = os.environ.get("AXE_CORE")
    if named:
        return Path(named)
    npm = shutil.which("npm")
    root = subprocess.run([npm, "root", "-g"], capture_output=True, text=True, check=False).stdout if npm else ""
    return Path(root.strip() or ".") / "axe-core" / "axe.min.js"


def violations(page):
    """Rules of axe-core that a page breaks, with the first element each; skips the test where axe-core is not here."""
    if not _axe().is_file():
        pytest.skip("axe-core is not installed (npm install -g axe-core, or AXE_CORE=.../axe.min.js)")
    page.evaluate(_axe().read_text(encoding="utf-8"))
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")["violations"]
    return [
        (each["id"], each["impact"], each["nodes"][0]["target"], each["nodes"][0]["failureSummary"]) for each in found
    ]
