"""Take the screenshot of the README: python scripts/report_picture.py out/demo-friction.html docs/report.png.

`make demo` writes the page. Requires playwright and chromium.
"""

import shutil
import sys
from pathlib import Path

SIZE = {"width": 1280, "height": 1290}


def take(page: Path, picture: Path) -> None:
    """Save the top of a page as an image."""
    from playwright.sync_api import sync_playwright

    path = shutil.which("chromium") or shutil.which("chromium-browser")
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=path, args=["--no-sandbox"])
        view = browser.new_page(viewport=SIZE, color_scheme="light")
        view.goto(page.resolve().as_uri())
        view.wait_for_function("[...document.querySelectorAll('figure > .chart')].some(chart => chart.data)")
        view.wait_for_timeout(500)
        view.screenshot(path=picture)
        browser.close()


if __name__ == "__main__":
    take(Path(sys.argv[1]), Path(sys.argv[2]))
