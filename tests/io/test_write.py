"""What is written reads back to the last bit, and nothing is left half-written."""

import errno
import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tierod.core.errors import MissingExtra, OutputError
from tierod.core.recording import Channel, Recording
from tierod.io.conversion import convert
from tierod.io.readers import read
from tierod.io.writers import require_writable, write

FORMATS = ("parquet", "csv", "mf4")
VALUES = st.one_of(st.floats(-1e6, 1e6), st.just(float("nan")))
NAMES = {
    "steering_wheel_angle": "rad",
    "driver_torque": "count",
    "yaw_rate": "rad/s",
    "vehicle_speed": "m/s",
    "my own, 'x'": "N*m/s",
}


@st.composite
def recordings(draw):
    channels = []
    clocks = []
    for name in draw(st.lists(st.sampled_from(sorted(NAMES)), min_size=1, max_size=5, unique=True)):
        if clocks and draw(st.booleans()):
            time = draw(st.sampled_from(clocks))
        else:
            steps = draw(st.lists(st.floats(1e-6, 100.0), min_size=2, max_size=20))
            time = draw(st.floats(0.0, 1e3)) + np.cumsum(steps)
            clocks.append(time)
        values = np.array(draw(st.lists(VALUES, min_size=len(time), max_size=len(time))))
        note = draw(st.sampled_from(["", "sign turned", "one; two"]))
        channels.append(Channel(name, time, values, NAMES[name], f"ECU.{name}", note))
    return Recording({channel.name: channel for channel in channels}, {"comment": "test", "origin": 1.6e9})


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.parametrize("ending", FORMATS)
@given(recording=recordings())
def test_round_trip(tmp_path, ending, recording):
    if ending == "mf4":
        pytest.importorskip("asammdf")
    path = tmp_path / f"drive.{ending}"
    write(recording, path)
    again = read(path)
    clocks = [channel.time.tolist() for channel in recording.channels.values()]
    together = sorted(recording.names, key=lambda name: clocks.index(recording[name].time.tolist()))
    assert again.names == tuple(together), "in their order, but channels with one clock stand together"
    for name, channel in recording.channels.items():
        back = again[name]
        assert np.array_equal(back.time, channel.time)
        assert np.array_equal(back.values, channel.values, equal_nan=True)
        assert (back.unit, back.source) == (channel.unit, channel.source)
        assert set(channel.note.split("; ")) <= set(back.note.split("; ")) | {""}
    assert again.metadata["origin"] == pytest.approx(1.6e9)


@pytest.mark.parametrize("ending", ["PARQUET", "CSV", "MF4"])
def test_an_ending_in_capitals(tmp_path, ending):
    if ending == "MF4":
        pytest.importorskip("asammdf")
    time = np.arange(5.0)
    write(Recording({"yaw_rate": Channel("yaw_rate", time, 0.1 * time, "rad/s")}), tmp_path / f"drive.{ending}")
    assert [path.name for path in tmp_path.iterdir()] == [f"drive.{ending}"]
    assert read(tmp_path / f"drive.{ending}")["yaw_rate"].values.tolist() == (0.1 * time).tolist()


@pytest.mark.parametrize("ending", FORMATS)
def test_metadata_comes_back(tmp_path, ending):
    if ending == "mf4":
        pytest.importorskip("asammdf")
    metadata = {"scenario": 'name = "a"\n<b> & ü\n  c', "faults": [{"start": 1.5, "end": None}], "seed": 7}
    write(Recording(one().channels, metadata), tmp_path / f"drive.{ending}")
    again = read(tmp_path / f"drive.{ending}").metadata
    assert {key: again[key] for key in metadata} == metadata


def test_nan_and_padding_are_kept_apart(tmp_path):
    slow = Channel("yaw_rate", np.array([0.0, 1.0]), np.array([np.nan, 2.0]), "rad/s")
    fast = Channel("vehicle_speed", np.arange(0.0, 1.0, 0.1), np.arange(10.0), "m/s")
    for ending in ("parquet", "csv"):
        path = tmp_path / f"drive.{ending}"
        write(Recording({"yaw_rate": slow, "vehicle_speed": fast}), path)
        back = read(path)["yaw_rate"]
        assert back.time.tolist() == [0.0, 1.0]
        assert np.isnan(back.values[0])


def test_row_groups_cover_slices_of_time(tmp_path):
    import pyarrow.parquet as pq

    time, slow = np.arange(0.0, 300.0, 0.1), np.arange(0.0, 300.0, 1.0)
    channels = {
        "yaw_rate": Channel("yaw_rate", time, time, "rad/s"),
        "vehicle_speed": Channel("vehicle_speed", slow, slow, "m/s"),
    }
    write(Recording(channels), tmp_path / "drive.parquet")
    file = pq.ParquetFile(tmp_path / "drive.parquet")
    assert file.num_row_groups == 5
    second = file.read_row_group(1).to_pydict()
    assert (second["time"][0], second["time.2"][0]) == (60.0, 60.0)
    assert second["time.2"][60] is None
    assert file.schema_arrow.field("yaw_rate").metadata[b"unit"] == b"rad/s"


def one() -> Recording:
    return Recording({"yaw_rate": Channel("yaw_rate", np.arange(3.0), np.arange(3.0), "rad/s")})


@pytest.mark.parametrize("ending", FORMATS)
def test_no_such_folder(tmp_path, ending):
    with pytest.raises(OutputError, match="no such file or directory; create the folder first"):
        write(one(), tmp_path / "absent" / f"drive.{ending}")


def test_the_target_is_a_folder(tmp_path):
    (tmp_path / "drive.csv").mkdir()
    with pytest.raises(OutputError, match="is a directory; name a file, not a folder"):
        write(one(), tmp_path / "drive.csv")


def test_unknown_ending(tmp_path):
    with pytest.raises(OutputError, match="no ending that can be written; did you mean '.parquet'"):
        write(one(), tmp_path / "drive.parqet")


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("drive.parqet", "did you mean '.parquet'"),
        ("drive", "no ending that can be written"),
        ("absent/drive.csv", "no folder .*absent; create it first"),
        ("folder.csv", "is a folder; name a file"),
    ],
)
def test_trouble_that_can_be_seen_before_a_long_run(tmp_path, name, sentence):
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(OutputError, match=sentence):
        require_writable(tmp_path / name)


def test_a_place_that_can_be_written(tmp_path):
    for ending in ("parquet", "csv"):
        require_writable(tmp_path / f"drive.{ending}")
    assert not list(tmp_path.iterdir())


def test_nothing_to_write(tmp_path):
    with pytest.raises(OutputError, match="has no channels"):
        write(Recording({}), tmp_path / "drive.csv")


@pytest.mark.parametrize(
    ("code", "sentence"),
    [
        (errno.ENOSPC, "no space left on device; make room on the disk or name another place"),
        (errno.EACCES, "permission denied; check the permissions of the folder"),
        (errno.EROFS, "name a place that can be written"),
        (errno.EIO, "check the disk or name another place"),
    ],
)
@pytest.mark.parametrize("ending", FORMATS)
def test_trouble_of_the_disk_leaves_the_old_file(tmp_path, monkeypatch, ending, code, sentence):
    path = tmp_path / f"drive.{ending}"
    path.write_bytes(b"old")

    def fail(*_args):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OutputError, match=sentence):
        write(one(), path)
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_mf4_without_asammdf(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "asammdf", None)
    with pytest.raises(MissingExtra, match=r"tierod\[mdf\]"):
        write(one(), tmp_path / "drive.mf4")
    with pytest.raises(MissingExtra, match=r"tierod\[mdf\]"):
        require_writable(tmp_path / "drive.mf4")


@pytest.mark.parametrize("ending", ["csv", "parquet", "mat", "mcap"])
def test_groups_of_several_rates_beyond_one_block_of_rows_are_converted(tmp_path, ending):
    fast, slow = np.arange(40_000) / 1000.0, np.arange(4_000) / 100.0
    channels = [Channel("yaw_rate", fast, np.sin(fast), "rad/s"), Channel("vehicle_speed", slow, 15.0 + slow, "m/s")]
    write(Recording({each.name: each for each in channels}), tmp_path / "in.parquet")
    convert([tmp_path / "in.parquet"], tmp_path / f"out.{ending}")
    if ending == "mat":
        return
    again = read(tmp_path / f"out.{ending}")
    for each in channels:
        assert np.array_equal(again[each.name].values, each.values)
