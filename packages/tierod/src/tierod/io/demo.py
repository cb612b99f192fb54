"""The recording of the demonstration, by `scripts/demo_recording.py`: friction rises from 4 to 8 N·m half-way."""

from __future__ import annotations

import shutil
from pathlib import Path

from tierod.core.errors import OutputError
from tierod.core.files import replacing

NAME = "demo-drive.parquet"
VEHICLE = "midsize-eps"


def copied(folder: Path) -> Path:
    """Copy the recording into a folder, and return its path."""
    path = folder / NAME
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"{folder} cannot be written ({error.strerror}); name another folder with --output"
        ) from error
    with replacing(path) as temporary:
        shutil.copyfile(Path(__file__).with_name(NAME), temporary)
    return path
