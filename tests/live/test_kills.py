"""Drives whose program is killed at any moment: log, checkpoint and fault memory are whole."""

import math
import os
import random
import shutil
import signal
import subprocess
import sys
import time

import pytest

from live_drives import CAR
from tierod.live import checkpoint
from tierod.live.log import is_unfinished

pytest.importorskip("cantools")
pytest.importorskip("asammdf")

WRITING = """
import sys, time, pathlib
sys.path[:0] = {path!r}
from live_drives import CAR, START, driven, frames_of_drive, started
from tierod.live.drive import Outputs
folder = pathlib.Path({folder!r})
outputs = Outputs(folder / "log.mf4", checkpoint=folder / "state.json", every=0.2)
run, inbox, _ = started(folder, outputs, folder / "car.json")
frames = frames_of_drive(folder, 60.0)
print("begins", flush=True)
for begin in range(0, len(frames), 40):
    for frame in frames[begin : begin + 40]:
        inbox.put(frame)
    run.tick(frames[begin].time, time.time())
    print(frames[begin + 39].time - START, flush=True)
"""


def killed(folder, pause, logged):
    """The time up to which frames were given when a drive was killed, so long after it began or had begun its log."""
    code = WRITING.format(path=[p for p in sys.path if p], folder=str(folder))
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    said = [process.stdout.readline().strip()]
    while logged and said[-1] and not (said[1:] and (folder / "log.mf4").exists()):
        said.append(process.stdout.readline().strip())
    time.sleep(pause)
    os.kill(process.pid, signal.SIGKILL)
    said += process.communicate(timeout=30)[0].split()
    return float(said[-1]) if said[1:] else 0.0


def survives(folder, pause, logged=False):
    """What a kill cost: seconds of the log; NaN where nothing was logged yet, and whether there is a checkpoint."""
    from tierod.diagnosis.fault_memory import FaultMemory
    from tierod.io.readers.log import InOrder
    from tierod.io.readers.mdf import open_mdf

    until, lost = killed(folder, pause, logged), math.nan
    if (folder / "log.mf4").exists() and until > 0.0:
        assert is_unfinished(folder / "log.mf4")
        last = max(float(block.time[-1]) for block in InOrder(open_mdf(folder / "log.mf4")))
        lost = until - last
        assert lost < 1.0
    if (folder / "state.json").exists():
        assert not checkpoint.read(folder / "state.json").ended
    FaultMemory.opened(folder / "car.json", CAR.name)
    return lost, (folder / "state.json").exists()


def test_a_kill_leaves_what_was_written(tmp_path):
    lost, _ = survives(tmp_path, 0.2, logged=True)
    assert not math.isnan(lost)


@pytest.mark.slow
def test_a_hundred_kills_leave_what_was_written(tmp_path):
    chance, found = random.Random(5), []
    for number in range(100):
        folder = tmp_path / str(number)
        folder.mkdir()
        found.append(survives(folder, chance.uniform(0.0, 3.0)))
        shutil.rmtree(folder)
    logged = [lost for lost, _ in found if not math.isnan(lost)]
    print(f"{len(logged)} logs opened, at most {max(logged):.3f} s lost; {sum(kept for _, kept in found)} checkpoints")
    assert len(logged) > 80
