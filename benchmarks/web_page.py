"""Web application compared with its targets: `python -m benchmarks.web_page`.

Ten hours of 20 signals at 100 Hz and a fleet of 10 000 cars; with Playwright and chromium also the view in a browser.
Parts can be run alone by name: recording, browser, fleet.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import random
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

RATE, SIGNALS = 100.0, 20
KNOWN = ("driver_torque", "steering_wheel_angle", "vehicle_speed", "yaw_rate", "lateral_acceleration", "motor_torque")
PARTS = ("recording", "browser", "fleet")


def main() -> int:
    """Measure the named parts, and print a line per figure; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", default=PARTS)
    parser.add_argument("--hours", type=float, default=10.0)
    parser.add_argument("--cars", type=int, default=10_000)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tierod-bench-") as place:
        top = Path(place)
        for name in ("drives", "fleet"):
            (top / name).mkdir()
        if {"recording", "browser"} & set(given.parts):
            record(top / "drives" / "long.parquet", given.hours)
        if "fleet" in given.parts:
            fleet_of(top / "fleet", given.cars)
        with served(top) as server:
            if {"recording", "browser"} & set(given.parts):
                key = first_picture(server)
                for part, run in (("recording", zooms), ("browser", in_browser)):
                    if part in given.parts:
                        run(server, key)
            if "fleet" in given.parts:
                table(server)
            shown("memory of the server", f"{server.memory():.0f} MB", "400 MB")
    return 0


def shown(what: str, figure: str, target: str) -> None:
    print(f"{what:58} {figure:>28}   target {target}", flush=True)


def record(path: Path, hours: float) -> None:
    """Write signals with sines and noise as a Parquet file of another program."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    count, chance = int(3600.0 * RATE * hours), np.random.default_rng(1)
    time_ = np.arange(count) / RATE
    columns = {"time": time_}
    for number in range(SIGNALS):
        name = KNOWN[number] if number < len(KNOWN) else f"channel_{number}"
        columns[name] = np.sin(time_ * (0.1 + 0.05 * number)) + 0.1 * chance.standard_normal(count)
    pq.write_table(pa.table(columns), path)
    shown("recording", f"{path.stat().st_size / 1e6:.0f} MB, {hours:g} h x {SIGNALS} signals", "-")


def fleet_of(folder: Path, cars: int) -> None:
    from tierod_lab.fleet.virtual import FleetFile, drawn
    from tierod_lab.fleet.writing import shipped_law, write_estimates

    write_estimates(drawn(FleetFile("bench", cars=cars, start="2024-01-08", weeks=26)), folder, shipped_law())


class Server:
    """A server in a separate process."""

    def __init__(self, process: subprocess.Popen[str], address: str):
        self.process, self.address = process, address

    def raw(self, path: str, body: object = None, method: str = "GET", **query: Any) -> bytes:
        text = urllib.parse.urlencode(query, doseq=True)
        data = None if body is None else json.dumps(body).encode()
        headers = {"content-type": "application/json"}
        request = urllib.request.Request(f"{self.address}{path}?{text}", data, headers, method=method)
        with urllib.request.urlopen(request, timeout=120) as answer:
            return bytes(answer.read())

    def json(self, path: str, body: object = None, method: str = "GET", **query: Any) -> Any:
        return json.loads(self.raw(path, body, method, **query))

    def memory(self) -> float:
        """Resident memory of the server without mapped files [MB]."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return sum(float(line.split()[1]) for line in status.splitlines() if line.startswith("RssAnon")) / 1024.0


@contextlib.contextmanager
def served(top: Path) -> Iterator[Server]:
    words = ["serve", *(str(top / each) for each in ("drives", "fleet")), "--port", "0", "--no-browser",
             "--cache", str(top / "cache")]  # fmt: skip
    process = subprocess.Popen([sys.executable, "-m", "tierod", *words], stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    try:
        line = process.stderr.readline()
        yield Server(process, line.split("serving at ")[1].split("/ ")[0])
    finally:
        process.terminate()
        process.wait()


def first_picture(server: Server) -> str:
    """Measure the time from the request of a new file to its first picture and to its storage; returns its key."""
    time.sleep(4.0)  # the waiting worker process has finished its imports by then
    begin = time.perf_counter()
    job = server.json("/api/analyses", {"file": "drives/long.parquet"}, "POST")
    pictured = False
    while True:
        job = server.json(f"/api/jobs/{job['id']}")
        key = job["found"].get("series", "")
        if key and not pictured:
            pictured = True
            names = [each["name"] for each in server.json(f"/api/series/{key}")["signals"]]
            server.raw(f"/api/series/{key}/window", name=names, points=1400)
            shown("cold Parquet: first picture", f"{time.perf_counter() - begin:.2f} s", "1.5 s")
        if key and not key.startswith("p-"):
            break
        if job["state"] == "failed":
            raise SystemExit(job["text"])
        time.sleep(0.01)
    shown("cold Parquet: every signal kept in levels", f"{time.perf_counter() - begin:.1f} s", "-")
    return str(key)


def zooms(server: Server, key: str) -> None:
    """Measure the transfer of stretches of all signals from the server."""
    names = [each["name"] for each in server.json(f"/api/series/{key}")["signals"]]
    first, last = server.json(f"/api/series/{key}")["span"]
    took, chance = [], random.Random(1)
    for number in range(60):
        width = (last - first) * 10.0 ** -chance.uniform(0.0, 5.0) if number else last - first
        start = first + chance.uniform(0.0, 1.0) * (last - first - width)
        begin = time.perf_counter()
        content = server.raw(f"/api/series/{key}/window", name=names, start=start, stop=start + width, points=1400)
        took.append(1e3 * (time.perf_counter() - begin))
    shown("packet of 20 signals, whole recording", f"{took[0]:.0f} ms, {len(content) / 1e3:.0f} kB last", "300 ms")
    shown("packet of 20 signals, any zoom", _spread(took[1:]), "80 ms")


def in_browser(server: Server, key: str) -> None:
    """First picture, zoom and pan of 20 signals in chromium."""
    from playwright.sync_api import sync_playwright

    names = [each["name"] for each in server.json(f"/api/series/{key}")["signals"]]
    panels = ";".join(",".join(names[at : at + 4]) for at in range(0, 20, 4))
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1500, "height": 1000})
        address = f"{server.address}/recording?file=drives/long.parquet&signals={panels}"
        first = []
        for _ in range(7):
            stranger = browser.new_context(viewport={"width": 1500, "height": 1000})
            first.append(_pictured(stranger.new_page(), address))
            stranger.close()
        shown("browser: first picture of 20 signals, first visit", _spread(first), "300 ms")
        again = [_pictured(page, address) for _ in range(10)][1:]
        shown("browser: first picture of 20 signals, a later visit", _spread(again), "300 ms")
        page.evaluate(_MEASURE)
        shown("browser: zoom by a key until the new samples are drawn", _spread(page.evaluate("zooming()")), "80 ms")
        rates = page.evaluate("panning()")
        shown("browser: pan", f"{statistics.median(rates):.0f} frames/s", "40 frames/s")
        browser.close()


def _pictured(page: Any, address: str) -> float:
    """Time from the first byte of the server's response until every chart is drawn [ms]."""
    page.goto(address, wait_until="commit")
    drawn = page.wait_for_function(
        "() => document.querySelectorAll('.panel .uplot').length === 5 && performance.now()", polling="raf"
    )
    answered = page.evaluate("performance.getEntriesByType('navigation')[0].responseStart")
    return float(drawn.json_value()) - float(answered)


_MEASURE = """() => {
  performance.setResourceTimingBufferSize(100000);
  const chart = document.querySelector('.panel .plot');
  const frame = () => new Promise(requestAnimationFrame);
  const key = (name) => chart.dispatchEvent(new KeyboardEvent('keydown', { key: name, bubbles: true }));
  window.zooming = async () => {
    const took = [];
    for (let turn = 0; turn < 12; turn++) {
      const begin = performance.now(), before = performance.getEntriesByType('resource').length;
      key(turn < 8 ? '+' : '-');
      const until = begin + 3000;
      while (performance.now() < until && performance.getEntriesByType('resource').length === before) await frame();
      await frame();
      took.push(performance.now() - begin);
    }
    return took;
  };
  window.panning = async () => {
    const rates = [];
    for (let turn = 0; turn < 3; turn++) {
      const begin = performance.now();
      let count = 0;
      for (; performance.now() - begin < 1500; count++) {
        key(count % 40 < 20 ? 'ArrowRight' : 'ArrowLeft');
        await frame();
      }
      rates.push(1000 * count / (performance.now() - begin));
    }
    return rates;
  };
}"""


def table(server: Server) -> None:
    begin = time.perf_counter()
    found = server.json("/api/fleets/fleet")
    while "job" in found:
        job = server.json(f"/api/jobs/{found['job']['id']}")
        if job["state"] == "failed":
            raise SystemExit(job["text"])
        time.sleep(0.2)
        found = server.json("/api/fleets/fleet") if job["state"] == "done" else found
    shown(f"fleet of {found['vehicles']} cars worked out once", f"{time.perf_counter() - begin:.0f} s", "-")
    for what, query, target in (("table", {}, "300 ms"), ("filter", {"search": "car-01", "sort": "-level"}, "100 ms")):
        took = []
        for _ in range(15):
            begin = time.perf_counter()
            server.json("/api/fleets/fleet/cars", **query)
            took.append(1e3 * (time.perf_counter() - begin))
        shown(f"fleet: {what}", _spread(took), target)


def _spread(took: Sequence[float]) -> str:
    return f"{statistics.median(took):.0f} ms (worst {max(took):.0f})"


if __name__ == "__main__":
    sys.exit(main())
