"""Metadata of an MDF file beside its channels."""

import datetime
import time
import warnings

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.io.readers import read

asammdf = pytest.importorskip("asammdf")


@pytest.mark.parametrize("zone", ["UTC", "Asia/Tokyo"])
def test_a_local_start_without_its_zone_means_the_same_everywhere(tmp_path, monkeypatch, zone):
    if not hasattr(time, "tzset"):
        pytest.skip("the time zone of a process cannot be set on this system")
    stamps = np.arange(5.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = asammdf.MDF(version="4.10")
        file.append(asammdf.Signal(stamps, stamps, name="yaw_rate", unit="rad/s"))
        file.header.start_time = datetime.datetime(2024, 1, 1, 12)
        file.save(tmp_path / "drive.mf4")
        file.close()
    monkeypatch.setenv("TZ", zone)
    time.tzset()
    try:
        recording = read(tmp_path / "drive.mf4")
    finally:
        monkeypatch.undo()
        time.tzset()
    assert recording.metadata["origin"] == datetime.datetime(2024, 1, 1, 12, tzinfo=datetime.UTC).timestamp()
    assert recording.metadata["start_time"] == "2024-01-01T12:00:00"


def with_other_bus(path, frame, beside=None):
    """A file whose frames are of another bus than CAN, made by asammdf, and a signal beside them if wanted."""
    stamps = np.arange(20) / 100.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = asammdf.MDF(version="4.10")
        file.append(asammdf.Signal(np.array([b"\1\2\3\4"] * 20), stamps, name=frame, encoding="latin-1"))
        file.groups[0].channel_group.flags |= 2
        if beside:
            file.append(asammdf.Signal(np.sin(stamps), stamps, name=beside, unit="rad/s"))
        file.save(path)
        file.close()
    return path


@pytest.mark.parametrize(("frame", "kind"), [("ETH_Frame", "Ethernet"), ("LIN_Frame", "LIN"), ("FLX_Pdu", "FlexRay")])
def test_frames_of_other_buses_are_refused_in_a_sentence(tmp_path, frame, kind):
    path = with_other_bus(tmp_path / "drive.mf4", frame)
    with pytest.raises(InputError, match=rf"holds 20 frames of {kind}.*decodes CAN only.*export the signals"):
        read(path)


def test_signals_beside_frames_of_other_buses_are_read_with_a_remark(tmp_path):
    found = read(with_other_bus(tmp_path / "drive.mf4", "ETH_Frame", "yaw_rate"))
    assert len(found["yaw_rate"].time) == 20
    assert any(
        "20 frames of Ethernet (SOME/IP and PDUs within), which were left out" in each for each in found.warnings
    )


def unfinished(path):
    """A file that its recorder did not finish, of which asammdf makes a copy."""
    from tierod.live.clock import Frame
    from tierod.live.log import FrameLog

    log = FrameLog(path, 1_700_000_000.0)
    log.append([Frame(0.01 * place, 0x100, 1, bytes(8)) for place in range(500)])
    return path


@pytest.mark.parametrize("how", ["to its end", "broken off", "child killed"])
def test_reading_leaves_nothing_among_the_temporary_files(tmp_path, monkeypatch, how):
    import os
    import signal
    import tempfile

    from tierod.io.readers.reader_process import MdfProcess

    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    for path in (unfinished(tmp_path / "half.mf4"), with_other_bus(tmp_path / "drive.mf4", "LIN_Frame", "yaw_rate")):
        process = MdfProcess(path)
        process.ask({})
        assert list(folder.iterdir()), "while it reads, its folder is there"
        if how == "to its end":
            assert list(process.lane(0, None)) if path.name == "half.mf4" else True
        if how == "child killed":
            os.kill(process._reader.pid, signal.SIGKILL)
            assert process._reader.code(10.0) == -signal.SIGKILL
        process.close()
        assert list(folder.iterdir()) == []


def test_what_a_killed_program_left_is_removed_by_the_next(tmp_path):
    import os
    import subprocess
    import sys

    from tierod.io.readers import reader_process

    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    for number, name in ((gone.pid, "left"), (os.getpid(), "own")):
        (tmp_path / f"{reader_process.PREFIX}{number}-{name}").mkdir()
    (tmp_path / "other").mkdir()
    reader_process._sweep(str(tmp_path))
    assert sorted(each.name for each in tmp_path.iterdir()) == ["other", f"{reader_process.PREFIX}{os.getpid()}-own"]


def saved(path, *groups):
    """A file of groups of signals with common stamps."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = asammdf.MDF(version="4.10")
        for group in groups:
            file.append(list(group), common_timebase=True)
        file.save(path)
        file.close()
    return path


def test_samples_with_an_invalidation_bit_are_missing_and_all_others_keep_their_stamps(tmp_path):
    stamps = np.arange(6000) / 100.0
    bad = (stamps >= 30.0) & (stamps < 30.5)
    angle = np.where(bad, 999.0, 30.0 * np.sin(stamps / 2.0))
    state = {"val_0": 0, "text_0": b"off", "val_1": 1, "text_1": b"on", "default": b""}
    signal = asammdf.Signal
    found = read(saved(
        tmp_path / "drive.mf4",
        [
            signal(angle, stamps, name="steering_wheel_angle", unit="deg", invalidation_bits=bad),
            signal(50.0 + np.sin(stamps), stamps, name="vehicle_speed", unit="km/h"),
            signal((stamps > 20.0).astype("u1") + 7 * bad.astype("u1"), stamps, name="state", conversion=state,
                   invalidation_bits=bad),
        ],
        [
            signal((100 * np.sin(stamps)).astype("i2"), stamps, name="yaw_rate", unit="deg/s",
                   conversion={"a": 0.1, "b": 0.0}, invalidation_bits=bad),
            signal(stamps, stamps, name="lost", invalidation_bits=np.ones(len(stamps), dtype=bool)),
        ],
    ))  # fmt: skip
    for name, wanted in (("steering_wheel_angle", np.radians(angle)), ("state", 1.0 * (stamps > 20.0)),
                         ("yaw_rate", np.radians((100 * np.sin(stamps)).astype("i2") * 0.1))):  # fmt: skip
        assert np.array_equal(found[name].time, stamps)
        assert found[name].values == pytest.approx(np.where(bad, np.nan, wanted), nan_ok=True)
    assert np.isfinite(found["vehicle_speed"].values).all()
    assert np.isnan(found["lost"].values).all()


def test_invalidation_bits_are_read_beyond_the_first_piece_of_a_file(tmp_path):
    stamps = np.arange(300_000) / 1000.0
    bad = (stamps >= 290.0) & (stamps < 290.5)
    yaw_rate = asammdf.Signal(np.sin(stamps), stamps, name="yaw_rate", unit="rad/s", invalidation_bits=bad)
    speed = asammdf.Signal(stamps, stamps, name="vehicle_speed", unit="m/s")
    found = read(saved(tmp_path / "drive.mf4", [yaw_rate, speed]))
    assert np.array_equal(np.isnan(found["yaw_rate"].values), bad)
    assert np.isfinite(found["vehicle_speed"].values).all()


def test_frames_with_an_invalidation_bit_are_left_out_and_counted(tmp_path):
    stamps = np.arange(200) / 100.0
    fields = [("BusChannel", "u1"), ("ID", "u4"), ("IDE", "u1"), ("DLC", "u1"), ("DataLength", "u1"),
              ("DataBytes", "(8,)u1")]  # fmt: skip
    frames = np.zeros(200, dtype=[(f"CAN_DataFrame.{name}", kind) for name, kind in fields])
    frames["CAN_DataFrame.BusChannel"], frames["CAN_DataFrame.ID"] = 1, 0x120
    frames["CAN_DataFrame.DataLength"] = frames["CAN_DataFrame.DLC"] = 8
    frames["CAN_DataFrame.DataBytes"][:, 0] = np.arange(200)
    frame = asammdf.Signal(frames, stamps, name="CAN_DataFrame", invalidation_bits=stamps >= 1.5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = asammdf.MDF(version="4.10")
        file.append(frame)
        file.groups[0].channel_group.flags |= 2
        file.save(tmp_path / "bus.mf4")
        file.close()
    (tmp_path / "car.dbc").write_text(
        'VERSION ""\nBU_: X\nBO_ 288 M: 8 X\n SG_ count : 0|8@1+ (1,0) [0|255] "" X\n', encoding="ascii"
    )
    found = read(tmp_path / "bus.mf4", dbc=tmp_path / "car.dbc")
    (channel,) = found.channels.values()
    assert channel.values.tolist() == list(range(150))
    assert "50 of 200 frames are marked as invalid and were left out" in found.warnings
