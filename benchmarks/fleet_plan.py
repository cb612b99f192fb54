"""Extrapolation of `python -m benchmarks.fleet` to a million vehicles: cores, storage and cost, as Markdown.

python -m benchmarks.fleet > measured.json
python -m benchmarks.fleet_plan measured.json
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

VEHICLES = 1_000_000
HOURS_A_DAY = 1.0
USED = 0.7  # utilisation of a rented core, since tasks arrive unevenly
CORE_HOUR = 0.04  # $, a rented virtual core; assumed
GB_MONTH = 0.023  # $, object storage; assumed
PUTS, GETS = 2, 3  # requests per recording: write result and levels; list, look up result, read recording
PUT, GET = 5e-6, 4e-7  # $ per request; assumed


def plan(measured):
    """Rows of (quantity, friction alone, all monitors)."""
    hours = VEHICLES * HOURS_A_DAY
    recordings = hours * 3600.0 / measured["seconds"]
    rows = {}
    for name in ("friction", "all"):
        per_hour = measured[f"{name}_fleet_ms_per_hour"] / 1e3
        core_hours = hours * per_hour / 3600.0
        stored = hours * measured[f"{name}_result_bytes_per_hour"] / 1e9
        requests = recordings * (PUTS * PUT + GETS * GET)
        rented = core_hours / 24.0 / USED
        rows[name] = {
            "processor time per hour of driving [s]": f"{per_hour:.2f}",
            "core-hours a day": f"{core_hours:,.0f}",
            "cores, 70 % used": f"{rented:,.0f}",
            "memory, one worker per core [GB]": f"{rented * measured[f'{name}_memory_MB'] / 1e3:,.0f}",
            "recordings read a day [TB]": f"{recordings * measured['recording_bytes'] / 1e12:,.1f}",
            "results with levels, a day [GB]": f"{stored:,.0f}",
            "results kept for a year [TB]": f"{365.0 * stored / 1e3:,.1f}",
            "processor, $ a day": f"{core_hours / USED * CORE_HOUR:,.0f}",
            "requests, $ a day": f"{requests:,.0f}",
            "a year of results, $ a month": f"{365.0 * stored * GB_MONTH:,.0f}",
        }
    return [(what, rows["friction"][what], rows["all"][what]) for what in rows["friction"]]


def main():
    measured = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    print("| a million vehicles, an hour a day each | friction | all monitors that run |\n|---|---:|---:|")
    for row in plan(measured):
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
