"""The log of frames: an ordinary MF4 when it is finished, and one that opens when it was never finished."""

import errno
import json
import math
import os
import pickle
import random
import shutil
import signal
import subprocess
import sys
import time

import pytest

from can_logs import together
from live_drives import CAR, driven, frames_of_drive, started
from tierod.cli import main
from tierod.core.errors import OutputError
from tierod.io.readers.frames import EXTENDED, InOrder
from tierod.io.readers.mdf import open_mdf
from tierod.live.clock import Frame
from tierod.live.log import FrameLog, is_unfinished
from tierod.live.outputs import Outputs

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


pytest.importorskip("cantools")
pytest.importorskip("asammdf")

WRITING = """
import pathlib, pickle, sys, time
sys.path[:0] = {path!r}
from live_drives import START, started
from tierod.live.outputs import Outputs
folder = pathlib.Path({folder!r})
run, inbox, _ = started(folder, Outputs(folder / "log.mf4"), folder / "car.json")
frames = pickle.loads((folder / "frames").read_bytes())
print("begins", flush=True)
for begin in range(0, len(frames), 40):
    for frame in frames[begin : begin + 40]:
        inbox.put(frame)
    run.tick(frames[begin].time, time.time())
    print(frames[begin + 39].time - START, flush=True)
"""


def killed(folder, pause, until, frames):
    """Kill a drive `pause` seconds after it has taken frames up to `until` [s]; time up to which it had taken them."""
    code = WRITING.format(path=[p for p in sys.path if p], folder=str(folder))
    (folder / "frames").write_bytes(pickle.dumps(frames))
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    said = [process.stdout.readline().strip()]
    while until and said[-1] and not (said[1:] and float(said[-1]) > until):
        said.append(process.stdout.readline().strip())
    time.sleep(pause)
    os.kill(process.pid, signal.SIGKILL)
    said += process.communicate(timeout=30)[0].split()
    return float(said[-1]) if said[1:] else 0.0


def survives(folder, frames, pause, until=0.0):
    """Seconds that the log lost by a kill; NaN where nothing was logged yet. The fault memory can be opened."""
    from tierod.diagnosis.fault_memory import FaultMemory
    from tierod.io.readers.frames import InOrder
    from tierod.io.readers.mdf import open_mdf

    taken, lost = killed(folder, pause, until, frames), math.nan
    if (folder / "log.mf4").exists() and taken > 0.0:
        assert is_unfinished(folder / "log.mf4")
        lost = taken - max(float(block.time[-1]) for block in InOrder(open_mdf(folder / "log.mf4")))
        assert lost < 1.0
    FaultMemory.opened(folder / "car.json", CAR.name)
    return lost


def test_the_log_of_a_killed_drive_is_judged_as_the_drive_was(tmp_path, capsys):
    from tierod.io.readers.frames import heard
    from tierod.io.readers.mdf import open_mdf

    frames = frames_of_drive(tmp_path, 8.0)
    assert not math.isnan(survives(tmp_path, frames, 0.0, until=5.0))
    count = heard(open_mdf(tmp_path / "log.mf4")).frames
    run, inbox, events = started(tmp_path, Outputs())
    driven(run, inbox, frames[:count])
    run.close()
    (live,) = events[-1]["verdicts"].values()
    words = ["--vehicle", CAR.name, "--monitor", "friction", "--dbc", str(tmp_path / "car.dbc"), "--no-report"]
    main(["diagnose", str(tmp_path / "log.mf4"), *words, "--json"])
    finding = json.loads(capsys.readouterr().out)["findings"][0]
    assert finding["headline"] == events[-1]["headlines"]["friction"]
    assert {key: finding[key] for key in live} == live


@pytest.mark.slow
def test_a_hundred_kills_leave_what_was_written(tmp_path):
    chance, found, frames = random.Random(5), [], frames_of_drive(tmp_path, 60.0)
    for number in range(100):
        folder = tmp_path / str(number)
        folder.mkdir()
        found.append(survives(folder, frames, chance.uniform(0.0, 3.0)))
        shutil.rmtree(folder)
    logged = [lost for lost in found if not math.isnan(lost)]
    print(f"{len(logged)} logs opened, at most {max(logged):.3f} s lost")
    assert len(logged) > 80
