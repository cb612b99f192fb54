"""Drives whose program is killed at any moment: the log is whole, and `diagnose` judges it as the drive was judged."""

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

from live_drives import CAR, START, driven, frames_of_drive, started
from tierod.cli import main
from tierod.live.log import FrameLog, is_unfinished
from tierod.live.outputs import Outputs

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


def test_the_log_of_a_killed_drive_is_kept_and_the_command_that_judges_it_is_said(tmp_path, capsys):
    import shlex
    import threading

    import can

    frames = frames_of_drive(tmp_path, 5.0)
    log = FrameLog(tmp_path / "log.mf4", START)
    log.append([frame._replace(time=frame.time - START) for frame in frames])
    before = (tmp_path / "log.mf4").read_bytes()
    bus = ["--interface", "virtual", "--channel", "restarted", "--silence", "0.5", "--drives", "1", "--json"]
    car = ["--vehicle", CAR.name, "--monitor", "friction", "--dbc", str(tmp_path / "car.dbc")]

    def send():
        with can.Bus(interface="virtual", channel="restarted") as other:
            for frame in frames[:200]:
                other.send(can.Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=False))
                time.sleep(0.002)

    sender = threading.Timer(1.0, send)
    sender.start()
    main(["live", *bus, *car, "--log", str(tmp_path / "log.mf4")])
    sender.join()
    assert (tmp_path / "log.mf4").read_bytes() == before
    assert not is_unfinished(tmp_path / "log-2.mf4")
    said = [json.loads(text) for text in capsys.readouterr().out.splitlines()]
    text = next(each["text"] for each in said if "exists already" in each.get("text", ""))
    words = shlex.split(text.partition("Its drive was cut off: ")[2])
    assert words[:3] == ["tierod", "diagnose", str(tmp_path / "log.mf4")]
    assert main([*words[1:], "--no-report", "--json"]) in (0, 1, 2)
    assert json.loads(capsys.readouterr().out)["findings"][0]["monitor"].startswith("friction")


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
