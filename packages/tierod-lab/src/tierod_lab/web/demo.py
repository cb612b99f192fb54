"""The demo: a drive whose friction rises half-way, and a small virtual fleet at estimate level."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tierod.web.analysing import Say

MINUTES = 13.0
"""Duration of the demo drive [min]."""

CARS, WEEKS = 120, 52
"""Numbers of cars and of weeks of the demo fleet."""


def folders(folder: Path) -> tuple[Path, Path]:
    """Folders (recordings, results) of the demo.

    Args:
        folder: folder of the demo
    """
    return folder / "recordings", folder / "fleet"


def make(folder: Path, say: Say) -> dict[str, Any]:
    """Make those parts of the demo that do not exist yet.

    Args:
        folder: folder of the demo
        say: receives the progress

    Raises:
        OutputError: the demo cannot be written
    """
    recordings, fleet = folders(folder)
    recordings.mkdir(parents=True, exist_ok=True)
    path = recordings / "demo-drive.parquet"
    if not path.is_file():
        say(0.05, "driving the demo")
        _drive(path)
    if not (fleet / "findings" / "virtual.parquet").is_file():
        say(0.8, "drawing a virtual fleet")
        _fleet(fleet)
    return {"recording": str(path), "results": str(fleet)}


def _drive(path: Path) -> None:
    from tierod.io.writers import write
    from tierod_lab.ground import FrictionCourse, drive

    course = FrictionCourse.step(4.0, 8.0, at=30.0 * MINUTES)
    write(drive(minutes=MINUTES, friction=course, seed=1), path)


def _fleet(folder: Path) -> None:
    from tierod_lab.fleet.ageing import SECONDS_PER_DAY, Ageing, Linear
    from tierod_lab.fleet.virtual import FleetFile, Group, drawn
    from tierod_lab.fleet.writing import shipped_law, write_estimates

    day = SECONDS_PER_DAY
    worn = Ageing("worn", Linear(0.01 / day), 0.05, (100.0 * day, 250.0 * day))
    batches = (Group("rack batch", "2025-47", 0.25, 0.5), Group("rack batch", "2025-12", 0.25, 0.0))
    file = FleetFile("demo", cars=CARS, start="2024-01-08", weeks=WEEKS, groups=batches, ageing=(worn,), seed=1)
    write_estimates(drawn(file), folder, shipped_law())
