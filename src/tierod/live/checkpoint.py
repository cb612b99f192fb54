"""File format of a checkpoint: states of the monitors' blocks, and the state of the drive up to the last judged piece.

The file holds one line with the layout and the SHA-256 digest of the rest, one line of JSON, and the compressed arrays
to which the JSON refers by number. It is written completely or not at all, and a damaged file is refused. Nothing in
it is executed: see `snapshot`.
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
"""Version of the file layout."""

_HEAD = b"tierod checkpoint %d " % LAYOUT
_DIGEST = 64

OLDEST: Annotated[float, "s"] = 300.0
"""Age from which a checkpoint is refused, since the vehicle may have been driven in the meantime."""

AHEAD: Annotated[float, "s"] = 60.0
"""Largest negative age of a checkpoint that is accepted: the computer's clock may have been set back after writing."""

LONGEST: Annotated[int, "byte"] = 1 << 29
"""Largest size of a checkpoint file, and of its decompressed arrays."""


@dataclass(frozen=True)
class State:
    """Stored state of one monitor.

    Args:
        block: digest of its block, see `snapshot.digest_of_block`
        memory: state of the block
        calibration: digest of the baseline with which its session was opened
        variant: name of the variant
        rate: sampling rate of its grid [Hz]
        held: data that it collected over the drive; None where they cannot be written
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
        vehicle: its name
        car: digest of the vehicle's parameters and thresholds
        databases: digest of the messages and the channel map
        written: time of writing [s since 1970]
        clock: calendar time minus the computer's monotonic clock at that time [s]
        ended: whether the drive had ended, so that its results are in fault memory and report
        states: states by name of the monitor
        drive: state of the engine; None where the drive had ended
        log: path of the drive's log; "" for none
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
        """Time since the checkpoint was written [s]."""
        return datetime.datetime.now(datetime.UTC).timestamp() - self.written


def of_vehicle(vehicle: Vehicle) -> str:
    """Digest of a vehicle's parameters and thresholds, by which a checkpoint of a changed vehicle is refused."""
    parameters = [(each.name, each.value, each.standard_deviation) for each in vehicle.parameters.values()]
    return digest_of(sorted(parameters, key=lambda each: each[0]), json.dumps(dict(vehicle.thresholds), default=str))


class _Arrays:
    """Arrays in the order of their numbers, with type and shape of each."""

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
    """Write a checkpoint, completely or not at all.

    Args:
        content: what to write
        path: path of the file

    Raises:
        OutputError: the file cannot be written
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
    # Most bins of the traces stay empty for long: compression reduces the writes to a tenth.
    packed = pyarrow.Codec("zstd", 1).compress(data, asbytes=True)
    rest = json.dumps(document).encode() + b"\n" + packed
    with replacing(path) as temporary:
        temporary.write_bytes(_HEAD + hashlib.sha256(rest).hexdigest().encode() + b"\n" + rest)


def read(path: str | Path) -> Checkpoint:
    """Read a checkpoint from a file.

    Args:
        path: path of the file

    Raises:
        InputError: the file cannot be read, is damaged, or is of another version
    """
    content = read_bytes(path, "the checkpoint", most=LONGEST)
    if not content.startswith(_HEAD):
        # Layout 1 was a JSON object; such a file is intact, only older.
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
    """The error that reports why a checkpoint is not resumed.

    Args:
        path: path of the file
        why: the reason, as a main clause
    """
    return InputError(f"the checkpoint {path} is not used: {why}; the monitors begin anew")
