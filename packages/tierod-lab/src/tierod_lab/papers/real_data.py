"""Recordings of real cars and drives for the studies, which are not part of the repository."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from tierod.core.errors import MissingExtra
from tierod.core.recording import Recording

DATA = "TIEROD_DATA"  # Environment variable with the folder of the real recordings; the default is ../shared/data

NO_DATA = f"The recording is not here; name the folder that holds it with {DATA}."


def path_of(*parts: str) -> Path:
    """Path of a recording by its folders and file name, whether it exists or not."""
    return Path(os.environ.get(DATA, "../shared/data")).joinpath(*parts)


def recorded(*parts: str, **how: Any) -> Recording | None:
    """A recording with its derived signals; None where it or the library of its reader is missing."""
    from tierod.io.derive import complete
    from tierod.io.readers import read

    path = path_of(*parts)
    if not path.exists():
        return None
    try:
        return complete(read(path, **how))
    except MissingExtra:
        return None
