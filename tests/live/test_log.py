"""The log of frames: an ordinary MF4 when it is finished, and one that opens when it was never finished."""

import errno
import os
import shutil

import pytest

from can_logs import together
from tierod.core.errors import OutputError
from tierod.io.readers.frames import EXTENDED, InOrder
from tierod.io.readers.mdf import open_mdf
from tierod.live.clock import Frame
from tierod.live.log import FrameLog

asammdf = pytest.importorskip("asammdf")

FRAMES = [
    Frame(0.1 * place, 0x123 if place % 2 else 0x18FEF100 | EXTENDED, 1 + place % 2, bytes([place % 256] * 8))
    for place in range(500)
]


def read_back(path):
    return together(list(InOrder(open_mdf(path))))


def written(path, frames=FRAMES, width=8):
    log = FrameLog(path, 1_700_000_000.0, width, 'a "drive" & more')
    log.append(frames)
    return log


@pytest.mark.parametrize("finished", [True, False])
def test_every_frame_comes_back(tmp_path, finished):
    log = written(tmp_path / "drive.mf4")
    if finished:
        log.finish()
    found = read_back(tmp_path / "drive.mf4")
    assert found.time.tolist() == [frame.time for frame in FRAMES]
    assert found.identifier.tolist() == [frame.identifier for frame in FRAMES]
    assert [row.tobytes() for row in found.payload] == [frame.data for frame in FRAMES]
    assert found.buses == ("CAN1", "CAN2")
    assert found.origin == 1_700_000_000.0


def test_asammdf_opens_both(tmp_path):
    log = written(tmp_path / "drive.mf4")
    shutil.copy(tmp_path / "drive.mf4", tmp_path / "killed.mf4")
    log.finish()
    for name in ("drive.mf4", "killed.mf4"):
        with asammdf.MDF(tmp_path / name) as file:
            assert file.groups[0].channel_group.cycles_nr == len(FRAMES)
            assert set(file.bus_logging_map["CAN"]) == {1, 2}


@pytest.mark.parametrize("cut", [1, 7, 24, 25, 300])
def test_a_record_that_was_not_written_to_its_end_is_left_out(tmp_path, cut):
    written(tmp_path / "drive.mf4")
    os.truncate(tmp_path / "drive.mf4", (tmp_path / "drive.mf4").stat().st_size - cut)
    lost = -(-cut // 25)
    assert len(read_back(tmp_path / "drive.mf4")) in (len(FRAMES) - lost, len(FRAMES) - lost + 1)


def test_can_fd(tmp_path):
    frames = [Frame(0.01 * place, 0x7, 1, bytes(range(length))) for place, length in enumerate((3, 8, 12, 48, 64))]
    written(tmp_path / "fd.mf4", frames, 64).finish()
    found = read_back(tmp_path / "fd.mf4")
    assert found.length.tolist() == [3, 8, 12, 48, 64]
    assert [row[:length].tobytes() for row, length in zip(found.payload, found.length, strict=True)] == [
        frame.data for frame in frames
    ]


def test_a_full_disk_gives_a_sentence_and_leaves_whole_records(tmp_path, monkeypatch):
    log = written(tmp_path / "drive.mf4")
    real = os.write

    def full(descriptor, data):
        if len(data) > 30:
            return real(descriptor, bytes(data)[:30])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(OutputError, match=r"drive\.mf4 cannot be written: no space left on device; make room"):
        log.append(FRAMES[:2])
    monkeypatch.undo()
    log.finish()
    assert len(read_back(tmp_path / "drive.mf4")) == len(FRAMES)


def test_a_folder_that_is_missing(tmp_path):
    with pytest.raises(OutputError, match="there is no folder"):
        FrameLog(tmp_path / "no" / "drive.mf4", 0.0)
