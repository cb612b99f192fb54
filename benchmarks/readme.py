"""Insert the figures of bench.json into the performance page and the README, between marks; part of `make docs`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- figures from bench.json: begin -->", "<!-- figures from bench.json: end -->"

SAID = {
    "monitor-friction-single": "default friction monitor as `diagnose` runs it, one recording",
    "monitor-friction-lanes": "the same, many vehicles side by side, per vehicle",
    "monitor-driver-torque-single": "default monitor of the driver's torque, one recording",
    "monitor-driver-torque-lanes": "the same, many vehicles side by side, per vehicle",
    "monitor-sideslip-single": "default sideslip monitor, one recording",
    "monitor-sideslip-lanes": "the same, many vehicles side by side, per vehicle",
    "filter-single": "five-state friction filter as printed in the paper, one recording",
    "filter-lanes": "the same, many vehicles side by side, per vehicle",
    "push-bound": "one live sample, bound buffers",
    "can-decode": "CAN messages decoded",
    "diagnose-1h": "`tierod diagnose` on an hour at 100 Hz, process start to JSON and report",
    "simulate-eps-car": "virtual EPS car, two-track, 1 kHz, with its sensors",
    "condition-on-board": "condition monitor on board: bank of fifty filters, rules, substitutes, fault counters",
    "observer-bank": "torque of the hands, bank of three constant gains",
}


def table(rows: list[dict]) -> str:
    """The rows as a Markdown table."""
    lines = ["| what | figure | peer | times the peer |", "|---|---:|---|---:|"]
    for row in (each for each in rows if each["name"] in SAID):
        figure, peer = (f"{_number(row[key])} {row['unit']}" for key in ("value", "peer_value"))
        lines.append(f"| {SAID[row['name']]} | {figure} | {row['peer']}: {peer} | {_number(row['ratio'])} |")
    return "\n".join(lines)


def _number(value: float) -> str:
    return f"{value:,.0f}".replace(",", " ") if value >= 1000.0 else f"{value:.3g}"


SHORT = (
    "monitor-friction-single",
    "monitor-friction-lanes",
    "filter-single",
    "filter-lanes",
    "push-bound",
    "can-decode",
    "diagnose-1h",
    "simulate-eps-car",
)
"""Rows shown in the README; the performance page shows those of `SAID`."""


def put(page: Path, text: str) -> None:
    """Replace the text between the marks of a page."""
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    _, after = rest.split(END)
    page.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")
    print(f"wrote the figures of {page.relative_to(ROOT)}")


def main() -> int:
    """Insert the figures; does nothing without bench.json. Returns the exit code."""
    measured = ROOT / "bench.json"
    if not measured.exists():
        return 0
    rows = json.loads(measured.read_text(encoding="utf-8"))
    put(ROOT / "docs" / "explanation" / "performance.md", table(rows))
    put(ROOT / "README.md", table([row for row in rows if row["name"] in SHORT]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
