"""The fleet of the page's demo: virtual cars over a year at estimate level, one batch of which wears."""

from __future__ import annotations

from pathlib import Path

CARS, WEEKS = 120, 52  # Numbers of cars and of weeks of the demo fleet


def demo_fleet(folder: Path) -> None:
    from tierod_lab.fleet.virtual import SECONDS_PER_DAY, Ageing, FleetFile, Group, Linear, drawn
    from tierod_lab.fleet.writing import shipped_law, write_estimates

    day = SECONDS_PER_DAY
    worn = Ageing("worn", Linear(0.01 / day), 0.05, (100.0 * day, 250.0 * day))
    batches = (Group("rack batch", "2025-47", 0.25, 0.5), Group("rack batch", "2025-12", 0.25, 0.0))
    file = FleetFile("demo", cars=CARS, start="2024-01-08", weeks=WEEKS, groups=batches, ageing=(worn,), seed=1)
    write_estimates(drawn(file), folder, shipped_law())
