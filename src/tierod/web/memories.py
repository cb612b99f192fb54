"""Fault memories for the page, read from a copy, so that reading changes nothing."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError


def memory_document(path: Path) -> dict[str, Any]:
    """Trouble codes of a fault memory with their status, history and freeze frames.

    Args:
        path: path of its file

    Raises:
        InputError: the file is damaged, or is no fault memory
    """
    from tierod.diagnosis import sovd
    from tierod.diagnosis.fault_memory import FaultMemory
    from tierod.report.document import plain

    with tempfile.TemporaryDirectory(prefix="tierod-memory-") as folder:
        copy = Path(folder) / path.name
        try:
            shutil.copyfile(path, copy)
            memory = FaultMemory.opened(copy)
        except (OSError, InputError, KeyError, TypeError, ValueError) as error:
            reason = " ".join(str(error).replace(str(copy), path.name).split())[:200]
            raise InputError(f"{path.name} is not a fault memory that can be read ({reason})") from None
        stored = [name for name, entry in memory.entries.items() if entry.stored]
        found: dict[str, Any] = plain({
            "vehicle": memory.vehicle, "cycles": memory.cycles, "date": memory.date, "lamp": memory.lamp,
            "reaction": memory.reaction, "codes": [sovd.fault(memory, name) for name in stored],
        })  # fmt: skip
    return found
