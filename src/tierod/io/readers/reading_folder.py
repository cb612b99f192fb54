"""The temporary folder of a process that reads a file: libraries unpack there what they cannot read in place."""

from __future__ import annotations

import functools
import os
import shutil
import tempfile
from pathlib import Path

from tierod.core.processes import runs

PREFIX = "tierod-reading-"
"""Beginning of the name; the number of the process that removes it follows."""


def reading_folder() -> Path | None:
    """A new folder that the caller removes; None where no folder for temporary files can be written."""
    try:
        folder = tempfile.gettempdir()
        _sweep(folder)
        return Path(tempfile.mkdtemp(prefix=f"{PREFIX}{os.getpid()}-", dir=folder))
    except OSError:
        return None


@functools.cache
def _sweep(folder: str) -> None:
    """Remove what a killed program left, once in a program."""
    for each in Path(folder).glob(f"{PREFIX}*"):
        number = each.name.removeprefix(PREFIX).partition("-")[0]
        if number.isdigit() and not runs(int(number)):
            shutil.rmtree(each, ignore_errors=True)
