"""The file of a checkpoint: states of the monitors' blocks, and the drive as far as it was judged.

A line with the layout and the SHA-256 of the rest, a line of JSON, and the arrays that it numbers, packed. It is
written whole or not at all, and one that is damaged is refused. Nothing in it is run: see `snapshot`.
"""

from __future__ import annotations

import dataclasses
import datetime
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.files import replacing
from tierod.core.graph import Memory
from tierod.core.user_files import read_bytes
from tierod.core.version import __version__
from tierod.live.snapshot import ARRAYS, Snapshot, digest_of
from tierod.vehicles import Vehicle

LAYOUT = 2
_HEAD = b"tierod checkpoint %d " % LAYOUT
_DIGEST = 64

OLDEST: Annotated[float, "s"] = 300.0
"""Age from which on a checkpoint is not taken up: the car may have been driven on meanwhile."""

AHEAD: Annotated[float, "s"] = 60.0
"""By which a checkpoint may seem to come from the future, where the computer's clock was set back meanwhile."""

LONGEST: Annotated[int, "byte"] = 1 << 29


@dataclass(frozen=True)
class State:
    """State of one monitor.

    Args:
        block: digest of its block, see `snapshot.digest_of_block`
        memory: state of the block
        calibration: digest of what its session was opened for
        variant: its name
        rate: of its grid [Hz]
        held: what it collected over the drive; None where that cannot be written
    """

    block: str
    memory: Memory | None
    calibration: str
    variant: str
    rate: float
    held: Snapshot | None


@dataclass(frozen=True)
class Checkpoint:
    """Content of a checkpoint.

    Args:
        vehicle: name of it
        car: digest of its parameters
        databases: digest of messages and channel map
        written: when [s since 1970]
        clock: calendar time less the computer's clock then [s]
        ended: whether the drive had ended, so that its statements are in fault memory and report
        states: by monitor
        drive: what the engine holds; None where it had ended
        log: path of the drive's log; "" without
    """

    vehicle: str
    car: str
    databases: str
    written: float
    clock: float
    ended: bool
    states: Mapping[str, State] = field(default_factory=dict)
    drive: Snapshot | None = None
    log: str = ""

    @property
    def age(self) -> float:
        """Since it was written [s]."""
        return datetime.datetime.now(datetime.UTC).timestamp() - self.written


def of_vehicle(vehicle: Vehicle) -> str:
    """Digest of a vehicle's parameters and thresholds."""
    parameters = [(each.name, each.value, each.standard_deviation) for each in vehicle.parameters.values()]
    return digest_of(sorted(parameters, key=lambda each: each[0]), json.dumps(dict(vehicle.thresholds), default=str))


class _Arrays:
    """Arrays behind each other."""

    def __init__(self) -> None:
        self.rows: list[tuple[str, tuple[int, ...]]] = []
        self.arrays: list[np.ndarray] = []

    def add(self, array: np.ndarray) -> int:
        self.arrays.append(array)
        self.rows.append((array.dtype.newbyteorder("<").str, array.shape))
        return len(self.rows) - 1

    def of(self, found: Snapshot | None) -> Any:
        return None if found is None else [found.tree, [self.add(each) for each in found.arrays]]


def written(content: Checkpoint, path: str | Path) -> None:
    """Write a checkpoint, whole or not at all.

    Args:
        content: of it
        path: of the file

    Raises:
        OutputError: it cannot be written
    """
    arrays = _Arrays()
    states = {
        name: {
            **{each.name: getattr(state, each.name) for each in dataclasses.fields(State)},
            "memory": None if state.memory is None else [arrays.add(state.memory.values), state.memory.count],
            "held": arrays.of(state.held),
        }
        for name, state in content.states.items()
    }
    document = {
        **{each.name: getattr(content, each.name) for each in dataclasses.fields(Checkpoint)},
        "version": __version__, "states": states, "drive": arrays.of(content.drive), "arrays": arrays.rows,
    }  # fmt: skip
    little = [np.ascontiguousarray(each, each.dtype.newbyteorder("<")) for each in arrays.arrays]
    import pyarrow

    data = b"".join(each.tobytes() for each in little)
    document["length"] = len(data)
    # Most bins of the traces are empty for long: a tenth is written, which spares the disk.
    packed = pyarrow.Codec("zstd", 1).compress(data, asbytes=True)
    rest = json.dumps(document).encode() + b"\n" + packed
    with replacing(path) as temporary:
        temporary.write_bytes(_HEAD + hashlib.sha256(rest).hexdigest().encode() + b"\n" + rest)


def read(path: str | Path) -> Checkpoint:
    """The checkpoint in a file.

    Args:
        path: of the file

    Raises:
        InputError: the file cannot be read, is damaged, or of another version
    """
    content = read_bytes(path, "the checkpoint", most=LONGEST)
    if not content.startswith(_HEAD):
        known = content.startswith((b"tierod checkpoint", b'{"layout"'))
        raise refused(path, "it is of another version of tierod" if known else "it is damaged, or no checkpoint")
    digest, rest = content[len(_HEAD) : len(_HEAD) + _DIGEST], content[len(_HEAD) + _DIGEST + 1 :]
    if hashlib.sha256(rest).hexdigest().encode() != digest:
        raise refused(path, "it is damaged")
    try:
        text, _, data = rest.partition(b"\n")
        document = json.loads(text)
        if document.pop("version") != __version__:
            raise refused(path, f"it is of another version of tierod than {__version__}")
        return _content(document, _arrays(document.pop("arrays"), _unpacked(data, document.pop("length"))))
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError, OverflowError, OSError):
        raise refused(path, "it is damaged") from None


def _unpacked(data: bytes, length: int) -> bytes:
    import pyarrow

    if not 0 <= length <= LONGEST:
        raise ValueError("no such length")
    return bytes(pyarrow.Codec("zstd").decompress(data, decompressed_size=length, asbytes=True)) if length else b""


def _content(document: dict[str, Any], arrays: Sequence[np.ndarray]) -> Checkpoint:
    def snapshot(found: Any) -> Snapshot | None:
        return None if found is None else Snapshot(found[0], [arrays[place] for place in found[1]])

    states = {}
    for name, each in document["states"].items():
        memory = None if each["memory"] is None else Memory(arrays[each["memory"][0]], int(each["memory"][1]))
        states[name] = State(**{**each, "memory": memory, "held": snapshot(each["held"])})
    return Checkpoint(**{**document, "states": states, "drive": snapshot(document["drive"])})


def _arrays(rows: Sequence[Any], data: bytes) -> list[np.ndarray]:
    found, at = [], 0
    for name, shape in rows:
        kind = np.dtype(name)
        if kind.kind not in ARRAYS:
            raise ValueError("no array of numbers or text")
        count = int(np.prod(shape, dtype=np.int64))
        found.append(np.frombuffer(data, kind, count, at).reshape(shape).copy())
        at += count * kind.itemsize
    return found


def refused(path: str | Path, why: str) -> InputError:
    """The error that a checkpoint is not taken up.

    Args:
        path: of its file
        why: as a main clause
    """
    return InputError(f"the checkpoint {path} is not taken up: {why}; the monitors begin anew")
