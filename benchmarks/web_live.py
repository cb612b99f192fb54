"""Live page over a long time: `python -m benchmarks.web_live --minutes 60`.

50 signals at 100 Hz on a multicast bus are shown in chromium. Measured are the memory of the page after garbage
collection, and the delay from sending a frame until its value is shown.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import os
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.web_page import shown

RATE, MESSAGES = 100.0, 13
"""Sending rate [Hz], and number of messages with four signals each: 52 signals, the first of which is the clock."""

CHANNEL = "239.74.163.61"

KNOWN = (
    ("clock", 0.002, "s"), ("driver_torque", 0.001, "N*m"), ("motor_torque", 0.001, "N*m"),
    ("steering_wheel_angle", 0.0005, "rad"), ("steering_wheel_rate", 0.001, "rad/s"), ("yaw_rate", 0.0001, "rad/s"),
    ("lateral_acceleration", 0.001, "m/s**2"), ("vehicle_speed", 0.01, "m/s"),
)  # fmt: skip

ROOM = 600.0  # Time in which the page fills its memory for samples [s]

TURN = 60.0  # Period after which the clock on the bus wraps around [s]


def main() -> int:
    """Send, observe the page, and print a line per figure; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tierod-live-") as place:
        top = Path(place)
        (top / "bus.dbc").write_text(database())
        sender = multiprocessing.get_context("spawn").Process(target=send, daemon=True)
        sender.start()
        words = ["serve", "--live", f"udp_multicast:{CHANNEL}", "--dbc", str(top / "bus.dbc"), "--vehicle",
                 "midsize-eps", "--port", "0", "--no-browser", "--cache", str(top / "cache")]  # fmt: skip
        process = subprocess.Popen([sys.executable, "-m", "tierod", *words], stderr=subprocess.PIPE, text=True)
        assert process.stderr is not None
        try:
            address = process.stderr.readline().split("serving at ")[1].split("/ ")[0]
            looked(address, 60.0 * given.minutes, process.pid)
        finally:
            process.terminate()
            process.wait()
            sender.terminate()
    return 0


def signals() -> list[tuple[str, float, str]]:
    """(name, factor, unit) of all signals on the bus."""
    return [*KNOWN, *((f"channel_{number}", 0.001, "N*m") for number in range(4 * MESSAGES - len(KNOWN)))]


def database() -> str:
    """Database of the bus, with four signals of 16 bits per message."""
    lines = ['VERSION ""', "NS_ :", "BS_:", "BU_: ECU"]
    for number in range(MESSAGES):
        lines += ["", f"BO_ {256 + number} Message{number}: 8 ECU"]
        for place, (name, factor, unit) in enumerate(signals()[4 * number : 4 * number + 4]):
            lines.append(f' SG_ {name} : {16 * place}|16@1- ({factor},0) [-70|70] "{unit}" ECU')
    return "\n".join(lines) + "\n"


def send() -> None:
    """Send all messages a hundred times a second, with the clock of this computer as first signal."""
    import can

    every, begin, turn = signals(), time.time(), 0
    with can.Bus(interface="udp_multicast", channel=CHANNEL) as bus:
        while True:
            turn += 1
            time.sleep(max(begin + turn / RATE - time.time(), 0.0))
            now = time.time()
            values = [now % TURN, *(math.sin(1.5 * now + place) for place in range(1, len(every)))]
            values[7] = 20.0
            raw = [round(value / factor) for value, (_, factor, _) in zip(values, every, strict=True)]
            for number in range(MESSAGES):
                data = struct.pack("<4h", *raw[4 * number : 4 * number + 4])
                bus.send(can.Message(arbitration_id=256 + number, data=data, is_extended_id=False))


def looked(address: str, seconds: float, server: int) -> None:
    """Observe the page for a time [s], and print its figures."""
    from playwright.sync_api import sync_playwright

    others = ",".join(f"Message2.channel_{number}" for number in range(3))
    panels = ";".join(("Message0.clock", "driver_torque,motor_torque", "steering_wheel_angle", others))
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1500, "height": 1000})
        page.goto(f"{address}/live?signals={panels}")
        page.wait_for_function("() => document.querySelectorAll('.panel .uplot').length === 4", timeout=240_000)
        page.wait_for_timeout(10_000)  # frames received before the page was open are shown at once
        page.evaluate(_WATCH, TURN)
        session = page.context.new_cdp_session(page)
        session.send("Performance.enable")
        until, heaps, delays = time.monotonic() + seconds, [], []
        while time.monotonic() < until:
            page.wait_for_timeout(min(60_000.0, 1e3 * seconds / 10.0))
            delays += page.evaluate("delays.splice(0)")
            heaps.append(heap(session))
            shown(f"  after {(seconds - until + time.monotonic()) / 60.0:.0f} min: heap, delay",
                  f"{heaps[-1]:.1f} MB, {statistics.median(delays[-500:]):.0f} ms", "-")  # fmt: skip
        count = page.evaluate("document.querySelectorAll('.tree .signal').length")
        browser.close()
    delays.sort()
    shown("signals and estimates on the page", f"{count}", "50")
    # The page fills its memory in ten minutes and then thins older samples; from then on it must not grow.
    full = [each for place, each in enumerate(heaps, 1) if place * seconds / len(heaps) > ROOM] or heaps
    half = len(full) // 2 or 1
    grown = f"{max(full[:half]):.0f}, {max(full[-half:]):.0f} MB"
    shown("largest heap, first and last half of the time after that", grown, "flat")
    at = [delays[len(delays) * share // 100] for share in (50, 95, 99)]
    shown("from sending to the figure on the page", f"{at[0]:.0f} ms", "200 ms")
    shown("  95 %, 99 % of all pictures", f"{at[1]:.0f}, {at[2]:.0f} ms", "-")
    shown("load of the machine, memory of the server", f"{os.getloadavg()[1]:.1f}, {resident(server):.0f} MB", "-")


_WATCH = """(turn) => {
  window.delays = [];
  const output = document.querySelector('.panel .chip output');
  let before = '';
  const look = () => {
    if (output.isConnected && output.textContent !== before) {
      before = output.textContent;
      const delay = 1000 * ((Date.now() / 1000 - +before % turn + turn) % turn);
      if (Number.isFinite(delay)) delays.push(delay);
    }
    requestAnimationFrame(look);
  };
  look();
}"""


def heap(session: Any) -> float:
    """Heap of the page after garbage collection [MB]."""
    session.send("HeapProfiler.collectGarbage")
    metrics = session.send("Performance.getMetrics")["metrics"]
    return float(next(each["value"] for each in metrics if each["name"] == "JSHeapUsedSize")) / 1e6


def resident(process: int) -> float:
    """Resident memory of a process without mapped files [MB]."""
    status = Path(f"/proc/{process}/status").read_text()
    return sum(float(line.split()[1]) for line in status.splitlines() if line.startswith("RssAnon")) / 1024.0


if __name__ == "__main__":
    sys.exit(main())
