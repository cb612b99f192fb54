"""One function opens every format, by content, and says in one sentence why it cannot."""

import contextlib
import gzip
import os
import subprocess
import sys
import threading

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.errors import InputError, MissingExtra, TierodError
from tierod.core.recording import Channel, Recording
from tierod.io.readers import open_chunks, open_source, read
from tierod.io.writers import write

SAMPLES = (
    "asammdf/ASAP2_Demo_V171.mf4",
    "mf4_css/examples_data-processing_LOG_17BD1DB7_00000006_00000170.MF4",
    "mf4_css/examples_data-processing_LOG_94C49784_00000005_00000002.MF4",
    "mf4_css/examples_other_asammdf-basics_input_00000001.MF4",
    "mf4_css/examples_other_concatenate-mf4-by-period_LOG_2F6913DB_00001089_00000001-63BEF5CD.MF4",
    "rosbag_plotjuggler/example.bag",
    "rosbag_plotjuggler/rosbag2_test_0.db3",
)
GNSS = "mf4_css/examples_other_concatenate-mf4-by-period_dbc_files_gnss.dbc"


def drive(seconds: float = 10.0) -> Recording:
    time = np.arange(0.0, seconds, 0.01)
    slow = np.arange(0.0, seconds, 0.1)
    channels = (
        Channel("steering_wheel_angle", time, np.sin(time), "rad", "EPS.Angle"),
        Channel("yaw_rate", time, 0.1 * np.cos(time), "rad/s"),
        Channel("vehicle_speed", slow, 10.0 + slow, "m/s"),
    )
    return Recording({channel.name: channel for channel in channels})


def sentence(error: TierodError) -> str:
    text = str(error)
    assert "\n" not in text
    assert len(text) < 500
    return text


def attempt(path) -> tuple[tuple[str, ...], str]:
    """The channels of a file, or the sentence that says why there are none."""
    try:
        return read(path).names, ""
    except (InputError, MissingExtra) as error:
        return (), sentence(error)


def test_every_sample_opens_or_says_why():
    folder = shared_data("reader_samples")
    opened = refused = 0
    for path in sorted(folder.rglob("*")):
        if path.is_dir() or path.suffix in (".txt", ".dbc", "") or path.name.startswith("."):
            continue
        names, said = attempt(path)
        opened += bool(names)
        refused += path.name in said
        assert bool(names) != (path.name in said)
    assert opened >= 1
    assert opened + refused >= 35


@pytest.mark.parametrize("name", SAMPLES)
def test_a_sample_by_itself(name):
    path = shared_data("reader_samples", *name.split("/"))
    pytest.importorskip("asammdf")
    expected = {".MF4": "CAN frames of", ".bag": "", ".db3": "", ".mf4": ""}[path.suffix]
    names, said = attempt(path)
    assert expected in said
    assert bool(names) == (expected == "")


def test_a_bus_log_in_mf4_is_decoded():
    pytest.importorskip("asammdf")
    path = shared_data("reader_samples", *SAMPLES[4].split("/"))
    recording = read(path, dbc=shared_data("reader_samples", *GNSS.split("/")))
    speed = recording["vehicle_speed"]
    assert speed.source.startswith("gnss_speed.Speed (0x")
    assert speed.unit == "m/s"
    assert len(speed.time) > 10
    assert 0.0 <= np.nanmin(speed.values) < np.nanmax(speed.values) < 60.0
    assert recording.metadata["origin"] > 1.6e9


def test_formats_of_vendors_are_decoded(tmp_path):
    pytest.importorskip("can")
    path = shared_data("reader_samples", "python_can", "test", "data", "issue_1256.asc")
    dbc = tmp_path / "some.dbc"
    dbc.write_text('VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A\n\nBO_ 100 M: 8 A\n SG_ S : 0|8@1+ (1,0) [0|0] "km/h" A\n')
    assert read(path, dbc=dbc)["M.S"].values[:3].tolist() == [0x64, 0x6C, 0x74]


def test_lines_that_are_left_out_are_not_logged(tmp_path, caplog):
    pytest.importorskip("can")
    log = (
        b";$FILEVERSION=1.1\n;\n     1)      1.0  Rx         0100  1  01\n     2)      2.0  Rx         0100  8  01 02\n"
    )
    (tmp_path / "drive.trc").write_bytes(log)
    with pytest.raises(InputError, match="holds 1 CAN frames"):
        read(tmp_path / "drive.trc")
    assert caplog.records == []


@pytest.mark.parametrize("name", ["test_CanMessage.asc.gz", "test_CanMessage.blf", "test_CanMessage_V1_1.trc"])
def test_a_log_without_database_names_its_identifiers(name):
    pytest.importorskip("can")
    path = shared_data("reader_samples", "python_can", "test", "data", name)
    with pytest.raises(
        InputError, match=r"holds \d+ CAN frames of \d+ identifiers \(0x.*give it with dbc=.*under \[channels\]"
    ):
        read(path)


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("drive.mf4", b"", "is empty; record or copy it again"),
        ("drive.csv", b"\n \n", "is empty"),
        ("drive.parquet", b"PAR1" + b"\x01" * 400, "damaged or cut off and cannot be read as Parquet"),
        ("drive.mf4", b"MDF     4.10    " + b"\x01" * 400, "damaged or cut off and cannot be read as MDF"),
        ("drive.mat", b"MATLAB 5.0 MAT-file".ljust(126) + b"\x01IM" + b"\x01" * 40, "cannot be read as MATLAB"),
        ("drive.mat", b"MATLAB 7.3 MAT-file" + b" " * 400, "cannot be read as HDF5"),
        ("drive.blf", b"LOGG" + b"\x01" * 400, "the BLF log"),
        ("drive.mf4", b"\x00\x01\x02" * 100, "is not a mdf file, or its beginning is damaged"),
        ("drive.xyz", b"\x00\x01\x02" * 100, "has no known format"),
        ("drive.xlsx", b"PK\x03\x04" + b"\x00" * 100, "export the sheet as CSV"),
        ("drive.mcap", b"\x89MCAP0\r\n" + b"\x00" * 100, "MCAP"),
        ("drive.log.gz", b"\x1f\x8b" + b"\x00" * 100, "cannot be unpacked"),
        ("drive.txt", b"hello world\n" * 20, "holds no table of numbers"),
        ("drive.asc", b"date Sam\nbase hex  timestamps absolute\n", "ASC log"),
        ("can.log", b"nothing of a log\n", "holds no CAN frame"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path, name, content, expected):
    for library in ("asammdf", "can"):
        pytest.importorskip(library)
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InputError, match=expected) as caught:
        read(path)
    assert name in sentence(caught.value)


def test_absent_file_and_folder(tmp_path):
    with pytest.raises(InputError, match="there is no file"):
        read(tmp_path / "absent.csv")
    with pytest.raises(InputError, match="is a folder"):
        read(tmp_path)


@pytest.mark.parametrize("ending", ["parquet", "mf4"])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9, 0.99])
def test_half_a_file_is_refused_in_one_sentence(tmp_path, ending, share):
    path = tmp_path / f"drive.{ending}"
    write(drive(), path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    names, said = attempt(path)
    assert names or "again" in said


def test_half_a_log_gives_its_good_part(tmp_path):
    path = tmp_path / "can.log"
    path.write_text("".join(f"({k}.0) can0 260#0001000000000000\n" for k in range(10)) + "(10.0) can0 260#00")
    found = read(path, dbc="rav4")
    assert len(found["driver_torque"].time) == 11
    assert np.isnan(found["driver_torque"].values[-1]), "the last frame was cut, so its torque is missing"


@pytest.mark.parametrize("ending", ["parquet", "mf4", "csv"])
def test_the_content_counts_not_the_ending(tmp_path, ending):
    path = tmp_path / f"drive.{ending}"
    write(drive(), path)
    wrong = path.rename(tmp_path / ("drive.csv" if ending != "csv" else "drive.mf4"))
    recording = read(wrong)
    assert recording.names == drive().names
    assert "belongs to" in recording.warnings[0]


def test_packed_text(tmp_path):
    path = tmp_path / "drive.csv.gz"
    path.write_bytes(gzip.compress(b"time,speed [m/s]\n0,1\n1,2\n2,3\n"))
    assert read(path)["vehicle_speed"].values.tolist() == [1.0, 2.0, 3.0]


def test_a_packed_table_of_numbers_is_to_be_unpacked(tmp_path):
    path = tmp_path / "drive.parquet.gz"
    path.write_bytes(gzip.compress(b"PAR1" + bytes(100)))
    with pytest.raises(InputError, match="is packed.*gunzip -k"):
        read(path)


def test_a_wrong_shipped_name():
    pytest.importorskip("cantools")
    log = shared_data("rav4_highway_minute", "can.log")
    with pytest.raises(InputError, match="tierod ships no 'rav5.dbc'; did you mean 'rav4'"):
        read(log, dbc="rav5")


def test_a_folder_does_not_hide_the_shipped_name(tmp_path, monkeypatch):
    (tmp_path / "can.log").write_text("".join(f"({k}.0) can0 260#0001000000000000\n" for k in range(10)))
    (tmp_path / "rav4").mkdir()
    (tmp_path / "mine").mkdir()
    monkeypatch.chdir(tmp_path)
    assert "driver_torque" in read("can.log", dbc="rav4")
    recording = read("can.log", dbc="rav4", channel_map="rav4")
    assert recording.metadata["channel_map"].endswith("rav4.channels.toml")
    with pytest.raises(InputError, match="there is no file mine, and tierod ships no 'mine.dbc'"):
        read("can.log", dbc="mine")


@pytest.mark.parametrize(
    ("times", "expected"),
    [
        ("0 1 2 3 0 1 2", "jumps back from 3.000000 s to 0.000000 s at sample 5"),
        ("5 5 5 5 5", "stands still at 5 s"),
    ],
)
def test_time_that_jumps_or_stands(tmp_path, times, expected):
    path = tmp_path / "drive.csv"
    path.write_text("time,speed [m/s]\n" + "".join(f"{time},{k}\n" for k, time in enumerate(times.split())))
    with pytest.raises(InputError, match=expected):
        read(path)


def test_a_log_whose_clock_jumps_back(tmp_path):
    path = tmp_path / "can.log"
    path.write_text("".join(f"({t}.0) can0 260#0001000000000000\n" for t in (5, 6, 7, 2, 3)))
    with pytest.raises(InputError, match="time of the log can.log jumps back"):
        read(path, dbc="rav4")


def test_a_log_whose_clock_falls_back_a_little_is_put_in_order_and_says_so(tmp_path):
    path = tmp_path / "can.log"
    frame = "can0 024#0200000000000000"
    path.write_text("".join(f"({0.01 * k - 0.3 * (k >= 100):.6f}) {frame}\n" for k in range(200)))
    recording = read(path, dbc="rav4", names=["yaw_rate"])
    assert (np.diff(recording["yaw_rate"].time) >= 0.0).all()
    assert any("come up to 0.29 s late and were put in order" in each for each in recording.warnings)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
@pytest.mark.parametrize("packed", [False, True])
def test_nothing_is_lost_of_what_comes_through_a_pipe(tmp_path, packed):
    text = b"time,speed [m/s]\n" + b"".join(b"%d,%d\n" % (k, k % 9) for k in range(20_000))
    assert len(text) > 2 * (1 << 16), "longer than the part read to detect the format, and than the pipe holds"
    with piped(tmp_path / "pipe", gzip.compress(text) if packed else text) as path:
        recording = read(path)
    assert recording.span == (0.0, 19_999.0)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_table_that_must_be_sought_in_cannot_come_through_a_pipe(tmp_path):
    with piped(tmp_path / "pipe", b"PAR1" + bytes(100)) as path, pytest.raises(InputError, match="is a pipe"):
        read(path)


def test_a_name_that_no_file_can_have_is_refused():
    with pytest.raises(InputError, match="cannot be read"):
        read("a" * 300)


def test_the_name_of_a_pipe_is_reported(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="/dev/stdin"):
        read("-")


@contextlib.contextmanager
def piped(path, content):
    """A named pipe into which another thread writes."""
    os.mkfifo(path)
    writer = threading.Thread(target=path.write_bytes, args=(content,))
    writer.start()
    yield path
    writer.join()


@pytest.mark.parametrize("ending", ["parquet", "csv", "mf4"])
def test_chunks_make_the_whole(tmp_path, ending):
    path = tmp_path / f"drive.{ending}"
    whole = drive(35.0)
    write(whole, path)
    slices = list(open_chunks(path, seconds=10.0))
    assert [round(part.span[0]) for part in slices] == [0, 10, 20, 30]
    for name in whole.names:
        assert np.array_equal(np.concatenate([part[name].time for part in slices]), whole[name].time)
        assert np.array_equal(np.concatenate([part[name].values for part in slices]), whole[name].values)


def test_derived_signals_look_back_over_the_edge_of_a_chunk(tmp_path):
    path = tmp_path / "drive.parquet"
    write(drive(35.0), path)
    names = ["steering_wheel_angle", "steering_wheel_rate"]
    whole = read(path, names=names)["steering_wheel_rate"]
    slices = [part["steering_wheel_rate"] for part in open_chunks(path, names=names, seconds=10.0)]
    assert np.array_equal(np.concatenate([part.time for part in slices]), whole.time)
    assert np.array_equal(np.concatenate([part.values for part in slices]), whole.values, equal_nan=True)


def test_chunks_need_a_length(tmp_path):
    with pytest.raises(InputError, match="positive length"):
        next(open_chunks(tmp_path / "x.csv", seconds=0.0))


def test_only_wanted_columns_are_loaded(tmp_path):
    path = tmp_path / "drive.parquet"
    write(drive(), path)
    source, _ = open_source(path)
    (lane,) = source.lanes(["yaw_rate"])
    assert {channel.name for piece in lane for channel in piece.channels} == {"yaw_rate"}
    assert read(path, names=["yaw_rate"]).names == ("yaw_rate",)


def test_reading_parquet_imports_no_library_of_other_formats(tmp_path):
    path = tmp_path / "drive.parquet"
    write(drive(), path)
    code = "import sys; from tierod.io.readers import read; read(sys.argv[1]); "
    code += "print(sorted({'pandas', 'asammdf', 'cantools', 'can', 'pint', 'scipy'} & set(sys.modules)))"
    shown = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True).stdout
    assert shown == "[]\n"


@pytest.mark.parametrize(("library", "name"), [("asammdf", "drive.mf4"), ("can", "log.blf")])
def test_without_the_library_of_a_format(tmp_path, monkeypatch, library, name):
    path = tmp_path / name
    path.write_bytes({"asammdf": b"MDF     4.10    ", "can": b"LOGG" + bytes(200)}[library])
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingExtra, match="which is not installed; install it with: pip install"):
        read(path)


@pytest.mark.parametrize("ending", ["parquet", "csv"])
def test_slices_say_how_much_has_been_read(tmp_path, ending):
    time = np.arange(0.0, 100.0, 0.01)
    path = tmp_path / f"drive.{ending}"
    write(Recording({"yaw_rate": Channel("yaw_rate", time, np.sin(time), "rad/s")}), path)
    shares = [part.metadata["share_read"] for part in open_chunks(path, seconds=10.0)]
    assert len(shares) == 10
    assert shares == sorted(shares)
    assert 0.0 < shares[0] <= shares[-1] == pytest.approx(1.0)


def test_a_database_that_does_not_exist_is_reported_where_none_is_needed(tmp_path):
    path = tmp_path / "drive.csv"
    path.write_text("time,vehicle_speed [m/s]\n0.0,1\n0.1,2\n0.2,3\n")
    with pytest.raises(InputError, match="there is no CAN database .*absent.dbc; check the path"):
        read(path, dbc=tmp_path / "absent.dbc")
