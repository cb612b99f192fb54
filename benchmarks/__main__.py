"""Run all benchmarks, print the table, and write bench.json."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks import can_decode, diagnose_hour, filters, monitors, observers, on_board, simulate_eps_car

MODULES = (monitors, filters, on_board, observers, can_decode, diagnose_hour, simulate_eps_car)


def main() -> int:
    """Run, print and write; returns the exit code."""
    console = Console(width=None if sys.stdout.isatty() else 120)
    rows: list[dict] = []
    for module in MODULES:
        with console.status(f"measuring {module.__name__}"):
            rows += module.run()
    table = Table("name", "value", "unit", "peer", "peer's value", "ratio", "remarks")
    for row in rows:
        known = ("name", "value", "unit", "peer", "peer_value", "ratio")
        remarks = ", ".join(f"{key} {_number(value)}" for key, value in row.items() if key not in known)
        table.add_row(*(_number(row[key]) for key in known), remarks)
    console.print(table)
    path = Path("bench.json")
    path.write_text(json.dumps(rows, indent=2) + "\n")
    console.print(f"written: {path}")
    return 0


def _number(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    sys.exit(main())
