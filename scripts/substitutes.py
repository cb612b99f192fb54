"""Measure the error of every substitute of a sensor, and write the table used by the condition monitor.

python scripts/substitutes.py     # takes some minutes: calibrates three virtual vehicles and drives them
"""

from __future__ import annotations

import sys
from pathlib import Path

from tierod.core.files import write_text
from tierod.experiments.effort import Effort
from tierod.monitors.condition import substitutes
from tierod.monitors.condition.substitutes import FILTER, substitution_graph
from tierod.papers.condition.substitutes import HOURS, Error, measured

TABLE = Path(substitutes.__file__).with_name("substitutes.toml")
HEAD = """\
# What stands in for every sensor of the demonstrator. `deviation` is the root-mean-square error beside the true reading
# for vehicles that are calibrated, `uncalibrated` that by the shipped vehicle file, in the unit of the signal. Written
# by scripts/substitutes.py; `tierod study condition` measures the same.
"""
SOURCES = {
    True: "offsets on three vehicles, while declared",
    False: f"{HOURS:g} h of fault-free drives of three vehicles",
}


def text(errors: dict[str, dict[str, Error]]) -> str:
    """Text of the table, the most accurate substitute of every sensor first."""
    parts = [HEAD]
    for sensor, ways in substitution_graph().substitutes.items():
        for way in sorted(ways, key=lambda each: errors[sensor][each.name].calibrated):
            error = errors[sensor][way.name]
            needs = ", ".join(f'"{need}"' for need in way.needs)
            lines = (
                f"[[{sensor}]]",
                f'name = "{way.name}"',
                f"needs = [{needs}]",
                f"deviation = {float(f'{error.calibrated:.3g}')}",
                f"uncalibrated = {float(f'{error.uncalibrated:.3g}')}",
                f'source = "{SOURCES[way.name == FILTER]}"',
            )
            parts.append("\n".join(lines) + "\n")
    return "\n".join(parts)


def main() -> int:
    """Measure the errors and write the table."""
    write_text(TABLE, text(measured(Effort())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
