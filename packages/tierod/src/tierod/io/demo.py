"""The recording of the demonstration: a drive of 13 minutes whose friction rises from 4 to 8 N·m half-way.

`scripts/demo_recording.py` simulates it; the file holds the signals of a production car, and no truth.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from tierod.core.errors import OutputError

NAME = "demo-drive.parquet"
VEHICLE = "midsize-eps"


def copied(folder: Path) -> Path:
    """Copy the recording into a folder, and return its path.

    Raises:
        OutputError: the folder cannot be written
    """
    path = folder / NAME
    try:
        folder.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part")
        shutil.copyfile(Path(__file__).with_name(NAME), part)
        part.replace(path)
    except OSError as error:
        raise OutputError(f"{path} cannot be written ({error.strerror}); name another folder with --output") from error
    return path
