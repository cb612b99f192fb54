"""The demo of the page: the recording of the demonstration and, with tierod-lab, a small virtual fleet."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tierod.core import plugins as lab
from tierod.io.demo import NAME, copied
from tierod.web.analysing import Say


def folders(folder: Path) -> tuple[Path, Path]:
    """Folders (recordings, results) of the demo below its own folder."""
    return folder / "recordings", folder / "fleet"


def make(folder: Path, say: Say) -> dict[str, Any]:
    """Make those parts of the demo that do not exist yet."""
    recordings, fleet = folders(folder)
    if not (recordings / NAME).is_file():
        copied(recordings)
    if lab.installed() and not (fleet / "findings" / "virtual.parquet").is_file():
        say(0.5, "drawing a virtual fleet")
        lab.part("page", "the demo fleet").demo_fleet(fleet)
    return {"recording": str(recordings / NAME), "results": str(fleet)}
