"""A recording is the same to the last bit in whatever pieces its file is read and in whatever slices it comes."""

import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod.io.readers import content, mdf_child, open_chunks, read, tables, vectors, vendor_can
from tierod.io.readers.content import Allowance
from tierod.io.readers.slices import slices
from tierod.io.readers.source import Piece
from tierod.io.writers import write

SECONDS = 20.0

DBC = """VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A\n
BO_ 256 M: 8 A\n SG_ yaw_rate : 0|16@1- (0.001,0) [0|0] "rad/s" A
 SG_ vehicle_speed : 16|16@1- (0.01,0) [0|0] "m/s" A\n
BO_ 257 N: 8 A\n SG_ WHICH M : 0|8@1+ (1,0) [0|0] "" A\n SG_ steering_wheel_angle m1 : 8|16@1- (0.001,0) [0|0] "rad" A
"""


def drive() -> Recording:
    """Two clocks, one of them slow; equal and late stamps, infinite and missing values."""
    fast, slow = np.arange(0.0, SECONDS, 0.01), np.arange(0.0, SECONDS, 0.1)
    chance = np.random.default_rng(3)
    angle, yaw = chance.normal(size=(2, len(fast)))
    angle[5:9], yaw[700], yaw[1500] = np.nan, np.inf, -np.inf
    fast = fast.copy()
    fast[[100, 101]], fast[1000], fast[[1666, 1667]] = fast[[101, 100]], fast[999], fast[[1667, 1666]]
    channels = (
        Channel("steering_wheel_angle", fast, angle, "rad"),
        Channel("yaw_rate", fast, yaw, "rad/s"),
        Channel("vehicle_speed", slow, chance.normal(size=len(slow)) + 20.0, "m/s"),
    )
    return Recording({channel.name: channel for channel in channels})


def frames() -> list[tuple[float, int, bytes]]:
    chance = np.random.default_rng(4)
    rows = []
    for k in range(int(SECONDS * 50)):
        rows.append((0.02 * k, 0x100 + k % 2, chance.bytes(8 if k % 2 == 0 else 3)))
    rows[500], rows[501] = rows[501], rows[500]
    return [
        (time, name, bytes([k % 3]) + data[1:] if name == 0x101 else data) for k, (time, name, data) in enumerate(rows)
    ]


def made(path, ending: str):
    """A recording in the format of an ending."""
    if ending in ("parquet", "csv", "mf4"):
        write(drive(), path)
    elif ending == "csv.gz":
        write(drive(), path.with_suffix(""))
        path.write_bytes(gzip.compress(path.with_suffix("").read_bytes()))
    elif ending == "quoted.csv":
        rows = (
            f'{0.01 * k:.2f};"{k},5";"a{chr(10) * (k > 1250)}{k}";{"oops" if k % 400 == 7 else k}\n'
            for k in range(2000)
        )
        path.write_text("time;speed [m/s];note;yaw_rate [rad/s]\n" + "".join(rows))
    elif ending == "dates.csv":
        rows = (
            f"2024-05-29 13:53:{k // 100:02d}.{k % 100:02d}{'Z' if k % 7 == 0 else ''},{k},\xe4\n" for k in range(2000)
        )
        path.write_bytes(("timestamp,speed [m/s],text\n" + "".join(rows)).encode("latin-1"))
    elif ending == "utf16.csv":
        rows = (f"{0.01 * k:.2f},{k}\n" for k in range(2000))
        path.write_text("time,yaw_rate [°/s]\n" + "".join(rows) + "broken\n", encoding="utf-16")
    elif ending == "mat":
        scipy_io = pytest.importorskip("scipy.io")
        fast, slow = np.arange(0.0, SECONDS, 0.01), np.arange(0.0, SECONDS, 0.1)
        top = {"t": fast, "yaw_rate": np.sin(fast), "slow": {"time": slow, "ay": slow}, "rec": {"Ts": 0.5, "vx": slow}}
        scipy_io.savemat(path, top, do_compression=True)
    elif ending == "log":
        path.write_text("".join(f"({time + 1:.6f}) can0 {name:03X}#{data.hex()}\n" for time, name, data in frames()))
    else:
        _logged(path, ending)


def _logged(path, ending: str) -> None:
    can = pytest.importorskip("can")
    writer = {"asc": can.ASCWriter, "blf": can.BLFWriter, "trc": can.TRCWriter}[ending](str(path))
    for time, name, data in frames():
        writer.on_message_received(
            can.Message(timestamp=1.6e9 + time, arbitration_id=name, is_extended_id=False, data=data, channel=1)
        )
    writer.stop()


ENDINGS = (
    "parquet", "csv", "csv.gz", "quoted.csv", "dates.csv", "utf16.csv", "mat", "mf4", "log", "asc", "blf", "trc",
)  # fmt: skip


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cuts")
    (folder / "bus.dbc").write_text(DBC)
    return folder


def cut(monkeypatch, tmp_path, size: int) -> None:
    """Let every reader take pieces of about so many samples."""
    monkeypatch.setattr(content, "BLOCK", 20 * size)
    monkeypatch.setattr(tables, "BATCH", size)
    monkeypatch.setattr(vectors, "SAMPLES", size)
    monkeypatch.setattr(vendor_can, "BLOCK", size)
    source = Path(mdf_child.__file__).read_text()
    (tmp_path / "child.py").write_text(source.replace("FRAGMENT = 1 << 22", f"FRAGMENT = {24 * size}"))
    monkeypatch.setattr(mdf_child, "__file__", str(tmp_path / "child.py"))


def bits(parts: list[Recording]) -> dict[str, tuple]:
    """Everything that is known of a recording at its end, bit by bit."""
    found = {}
    for name, last in parts[-1].channels.items():
        every = [part[name] for part in parts if name in part]
        samples = (np.concatenate([getattr(each, what) for each in every]).tobytes() for what in ("time", "values"))
        found[name] = (*samples, last.unit, last.source, last.note)
    return found | {"warnings": parts[-1].warnings, "origin": parts[-1].metadata["origin"]}


@pytest.mark.parametrize("ending", ENDINGS)
def test_the_same_to_the_last_bit_however_cut(tmp_path, monkeypatch, files, ending):
    if ending == "mf4":
        pytest.importorskip("asammdf")
    path = files / f"drive.{ending}"
    made(path, ending)
    dbc = files / "bus.dbc" if ending in ("log", "asc", "blf", "trc") else None
    whole = bits([read(path, dbc=dbc)])
    assert len(whole) > 2
    for size in (37, 1000):
        with monkeypatch.context() as patch:
            cut(patch, tmp_path, size)
            assert bits([read(path, dbc=dbc)]) == whole
            assert bits(list(open_chunks(path, dbc=dbc, seconds=7.0))) == whole
    assert bits(list(open_chunks(path, dbc=dbc, seconds=0.9))) == whole


def test_lanes_that_lag_are_waited_for():
    fast, slow = np.arange(0.0, 40.0, 0.5), np.arange(0.0, 40.0, 4.0)
    every = {"fast": np.array_split(fast, 9), "slow": np.array_split(slow, 2), "late": np.array_split(fast + 35.0, 3)}
    lanes = [iter([Piece([Channel(name, part, part, "")], 0.5) for part in parts]) for name, parts in every.items()]
    found = list(slices(lanes, 10.0, Allowance("some file", 0)))
    for name, parts in every.items():
        of_it = [channel.time for part in found for channel in part.channels if channel.name == name]
        assert np.array_equal(np.concatenate(of_it), np.concatenate(parts))
    for part in found:
        stamps = np.concatenate([channel.time for channel in part.channels])
        assert math.floor(stamps.min() / 10.0) == math.floor(stamps.max() / 10.0)
    assert [part.share for part in found] == sorted(part.share for part in found)
    assert found[-1].share == 1.0


def test_a_diagnosis_does_not_depend_on_the_format_or_on_the_pieces(tmp_path, monkeypatch):
    from exact_vehicle import diagnose
    from tierod_lab.ground import drive as driven

    recording = driven(minutes=1.0, seed=2)
    found = {}
    for ending in ("parquet", "csv"):
        write(recording, tmp_path / f"drive.{ending}")
        found[ending] = diagnose(tmp_path / f"drive.{ending}", "midsize-eps")
        with monkeypatch.context() as patch:
            cut(patch, tmp_path, 500)
            again = diagnose(tmp_path / f"drive.{ending}", "midsize-eps")
        assert again.findings == found[ending].findings
        assert again.quality == found[ending].quality
    assert found["csv"].findings[0].estimate == found["parquet"].findings[0].estimate
