"""States of the monitors in a file, so that a drive goes on where a program ended."""

from __future__ import annotations

import base64
import datetime
import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from tierod import __version__
from tierod.core.block import tuning
from tierod.core.errors import InputError
from tierod.core.files import write_text
from tierod.core.graph import Memory
from tierod.core.user_files import MOST_DATA_BYTES, json_document, read_bytes
from tierod.live.judge import Judge
from tierod.monitors.harness.session import BlockSession
from tierod.vehicles import Vehicle

LAYOUT = 1
OLDEST: Annotated[float, "s"] = 300.0
"""Age from which on a checkpoint is not taken up: the car may have been driven on meanwhile."""


def stored(judges: Sequence[Judge], vehicle: Vehicle, path: str | Path) -> None:
    """Write the states of all monitors that run, whole or not at all.

    Args:
        judges: of the drive
        vehicle: that drives
        path: of the file

    Raises:
        OutputError: it cannot be written
    """
    states = {}
    for judge in judges:
        session = judge.run.session if judge.run else None
        if isinstance(session, BlockSession) and session.memory is not None:
            values = np.ascontiguousarray(session.memory.values, dtype="<f8").tobytes()
            states[judge.name] = {
                "block": _digest(session.block),
                "count": session.memory.count,
                "values": base64.b64encode(values).decode(),
            }
    document = {
        "layout": LAYOUT,
        "version": __version__,
        "vehicle": vehicle.name,
        "written": datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds"),
        "states": states,
    }
    write_text(path, json.dumps(document))


def _digest(block: Any) -> str:
    """Of a block's type and tuning: a state belongs to one calibration."""
    text = f"{type(block).__module__}.{type(block).__qualname__} {list(tuning(block))!r}"
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def taken_up(path: str | Path, vehicle: Vehicle, oldest: float = OLDEST) -> Mapping[str, tuple[str, Memory]]:
    """(digest of the block, state) by monitor.

    Args:
        path: of the file
        vehicle: that drives
        oldest: age from which on it is refused [s]

    Raises:
        InputError: the file is damaged, of another vehicle or version, or too old
    """
    try:
        document = json_document(read_bytes(path, "the checkpoint", most=MOST_DATA_BYTES))
        if document["layout"] != LAYOUT or document["version"] != __version__:
            raise _refused(path, f"it is of version {document['version']}, and this is {__version__}")
        if document["vehicle"] != vehicle.name:
            raise _refused(path, f"it is of the vehicle '{document['vehicle']}', and this is '{vehicle.name}'")
        age = (
            datetime.datetime.now(datetime.UTC) - datetime.datetime.fromisoformat(document["written"])
        ).total_seconds()
        if not -60.0 <= age <= oldest:
            raise _refused(path, f"it is {age:.0f} s old, and {oldest:.0f} s are the limit")
        return {name: (str(each["block"]), _memory(each)) for name, each in document["states"].items()}
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError):
        raise _refused(path, "it is damaged") from None


def _memory(state: Mapping[str, Any]) -> Memory:
    values = np.frombuffer(base64.b64decode(state["values"], validate=True), dtype="<f8").copy()
    count = state["count"]
    if not isinstance(count, int) or count < 0:
        raise ValueError("the count is no number of samples")
    return Memory(values, count)


def _refused(path: str | Path, why: str) -> InputError:
    return InputError(f"the checkpoint {path} is not taken up: {why}; the monitors begin anew")


def fits(judge: Judge, digest: str, memory: Memory) -> bool:
    """Whether a state belongs to the block that a monitor has opened."""
    session = judge.run.session if judge.run else None
    if not isinstance(session, BlockSession) or _digest(session.block) != digest:
        return False
    from tierod.core.graph import trace

    return bool(memory.values.shape == (trace(session.block).memory,))
