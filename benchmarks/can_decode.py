"""Decoding rate of CAN messages, compared with cantools' own loop over the same frames in the same run."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np

from benchmarks.timing import fastest, row
from tierod.io.readers.candump import frames_of
from tierod.io.readers.dbc import bus_source, load_databases
from tierod.io.readers.frames import EXTENDED, Frames, Log, heard, joined

_REPEATS = 7
_ROOT = Path(__file__).resolve().parents[1]
_DBC = _ROOT / "packages/tierod/src/tierod/vehicles" / "rav4.dbc"


def recorded() -> Frames | None:
    """Frames of the RAV4 log; None if it is not available."""
    folder = Path(os.environ.get("TIEROD_DATA", _ROOT.parent / "shared" / "data"))
    path = folder / "rav4_highway_minute" / "can.log"
    return joined(list(frames_of([path.read_bytes()]))) if path.exists() else None


def synthetic(seconds: float = 60.0) -> Frames:
    """A synthetic log with the same five messages at their rates, and random payloads."""
    rates = {0x260: 50.0, 0x025: 83.0, 0x024: 83.0, 0x0AA: 83.0, 0x2E4: 100.0}
    stamps = [np.arange(0.0, seconds, 1.0 / rate) for rate in rates.values()]
    time_ = np.concatenate(stamps)
    order = np.argsort(time_, kind="stable")
    identifier = np.concatenate([np.full(len(s), i, np.uint32) for i, s in zip(rates, stamps, strict=True)])[order]
    payload = np.random.default_rng(0).integers(0, 256, (len(time_), 8), dtype=np.uint8)
    return Frames(time_[order], identifier, np.zeros(len(time_), np.uint16), payload, np.full(len(time_), 8), ("can0",))


def run() -> list[dict]:
    """Rows of the benchmark table: messages per second, and ratio to the peer."""
    import cantools

    frames = recorded()
    frames = synthetic() if frames is None else frames
    log = Log("memory", lambda: [iter([frames])])
    database = load_databases([_DBC])
    peer = cantools.database.load_file(str(_DBC))
    known = {message.frame_id for message in database}
    rows = [(int(i & ~np.uint32(EXTENDED)), bytes(p)) for i, p in zip(frames.identifier, frames.payload, strict=True)]
    rows = [(identifier, payload) for identifier, payload in rows if identifier in known]

    def ours() -> None:
        source = bus_source(log, heard(log), database, {})
        for lane in source.lanes([column.name for column in source.columns]):
            list(lane)

    def theirs() -> None:
        for identifier, payload in rows:
            peer.decode_message(identifier, payload, decode_choices=False)

    value, peer_value = len(rows) / fastest(ours, _REPEATS), len(rows) / fastest(theirs, 3)
    return [row("can-decode", value, "messages/s", f"cantools {cantools.__version__} decode_message", peer_value)]


if __name__ == "__main__":
    print(json.dumps(run(), indent=2))
