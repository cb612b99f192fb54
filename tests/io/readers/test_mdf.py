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
    from tierod.live.frame import Frame
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
