"""Whole drives: buses, memory, report, ignition, lost buses, kills."""

import io
import json
import queue
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from live_drives import CAR, DBC, START, database_file, driven, frames_of_drive, started
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.io.readers.dbc import load_databases
from tierod.live.buses import Address, Receiver
from tierod.live.clock import Frame, Notice
from tierod.live.decoding import disagreements
from tierod.live.events import Events, Socket, line
from tierod.live.log import FrameLog, is_unfinished
from tierod.live.outputs import Outputs

can = pytest.importorskip("can")
pytest.importorskip("cantools")
pytest.importorskip("asammdf")


def kinds(events):
    return [each["event"] for each in events]


def test_a_drive_leaves_log_and_memory(tmp_path):
    outputs = Outputs(tmp_path / "log.mf4")
    drive, inbox, events = started(tmp_path, outputs, tmp_path / "car.json")
    driven(drive, inbox, frames_of_drive(tmp_path, 8.0))
    drive.close()
    assert {"begin", "state", "verdict", "memory", "end"} <= set(kinds(events))
    memory = FaultMemory.opened(tmp_path / "car.json", CAR.name)
    assert (memory.cycles, memory.open) == (1, False)
    assert (tmp_path / "log.mf4").read_bytes()[:3] == b"MDF"
    assert events[-1]["verdicts"].keys() == {"friction"}
    # Nothing changed in this drive.
    assert [events[-1]["verdicts"]["friction"][key] for key in ("since", "end", "declared")] == [None] * 3


def test_silence_ends_a_drive_and_the_next_one_gets_files_of_its_own(tmp_path):
    drive, inbox, events = started(tmp_path, Outputs(tmp_path / "log.mf4", silence=10.0))
    frames = frames_of_drive(tmp_path, 5.0)
    driven(drive, inbox, frames)
    drive.tick(frames[-1].time + 11.0, frames[-1].time + 11.0)
    assert kinds(events)[-1] == "end"
    driven(drive, inbox, [each._replace(time=each.time + 60.0) for each in frames])
    drive.close()
    assert drive.drives == 2
    assert (tmp_path / "log-2.mf4").exists()


def test_the_ignition_ends_a_drive(tmp_path):
    drive, inbox, events = started(tmp_path, Outputs(ignition="ESP.ignition"))
    frames = []
    for frame in frames_of_drive(tmp_path, 8.0):
        on = frame.identifier == 0x200 and frame.time < START + 5.0
        frames.append(frame._replace(data=frame.data[:6] + bytes([1]) + frame.data[7:]) if on else frame)
    driven(drive, inbox, frames)
    assert kinds(events).count("end") == 1


def test_what_happens_to_a_bus_is_said(tmp_path):
    drive, inbox, events = started(tmp_path, Outputs())
    now = time.monotonic()
    inbox.put(Notice(1, "lost", "bus 1 was lost: cable"))
    for _ in range(20):
        inbox.put(Notice(1, "error frame", "bus 1 reports an error frame"))
    drive.tick(now, START)
    drive.tick(now + 6.0, START + 6.0)
    texts = [each["text"] for each in events]
    assert "bus 1 was lost: cable" in texts
    assert texts.count("bus 1 reports an error frame") == 2
    assert any("the bit rate is wrong; give that of the bus with --bitrate" in text for text in texts)


def test_a_silent_bus_is_said_once(tmp_path):
    drive, _, events = started(tmp_path, Outputs())
    for more in (6.0, 7.0, 8.0):
        drive.tick(time.monotonic() + more, START)
    assert [each["text"] for each in events] == [
        "no frame was received for 5 s; switch the ignition on, and check channel and bit rate"
    ]


def test_a_receiver_on_a_virtual_bus_comes_back_after_the_bus_was_lost(monkeypatch):
    inbox = queue.SimpleQueue()
    receiver = Receiver(1, Address("virtual", "lost"), inbox)
    failing = receiver._bus

    def fail(timeout):
        raise can.CanOperationError("bus off")

    monkeypatch.setattr(failing, "recv", fail)
    receiver.start()
    found = [inbox.get(timeout=5.0), inbox.get(timeout=5.0)]
    assert [each.what for each in found] == ["lost", "back"]
    with can.Bus(interface="virtual", channel="lost") as other:
        other.send(can.Message(arbitration_id=5, data=[1, 2], is_extended_id=False))
        frame = inbox.get(timeout=5.0)
    receiver.end()
    assert (frame.identifier, frame.bus, frame.data) == (5, 1, b"\1\2")
    assert isinstance(frame, Frame)


def test_events_over_websocket():
    client = pytest.importorskip("websockets.sync.client")
    socket = Socket(0)
    with client.connect(f"ws://127.0.0.1:{socket.port}") as connection:
        until = time.monotonic() + 5.0
        while not socket._clients and time.monotonic() < until:
            time.sleep(0.01)
        socket(line("mark", {"time": 1.5, "value": float("nan")}))
        assert json.loads(connection.recv(5.0)) == {"event": "mark", "schema": 2, "time": 1.5, "value": None}
    socket.close()


CHANNEL = "239.74.163.77"


def _live(folder):
    words = ["live", "--interface", "udp_multicast", "--channel", CHANNEL, "--vehicle", "midsize-eps", "--monitor"]
    words += ["friction", "--dbc", str(folder / "car.dbc"), "--log", str(folder / "log.mf4"), "--json"]
    return subprocess.Popen(
        [sys.executable, "-m", "tierod", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def _sent(frames):
    with can.Bus(interface="udp_multicast", channel=CHANNEL) as bus:
        for frame in frames:
            message = can.Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=False)
            bus.send(message)
            time.sleep(0.0005)


@pytest.fixture
def multicast():
    try:
        with can.Bus(interface="udp_multicast", channel=CHANNEL):
            pass
    except (OSError, can.CanError) as error:
        pytest.skip(f"no multicast on this computer: {error}")


@pytest.mark.parametrize("ending", [pytest.param(signal.SIGKILL, marks=pytest.mark.slow), signal.SIGTERM])
def test_a_session_over_multicast_that_is_ended(tmp_path, multicast, ending):
    database_file(tmp_path)
    process = _live(tmp_path)
    log, frames = tmp_path / "log.mf4", frames_of_drive(tmp_path, 3.0)
    begun = time.monotonic()
    # The first frames come while the session starts; they are sent again until the log is there.
    while not log.exists() and time.monotonic() < begun + 60.0:
        _sent(frames[:20])
    _sent(frames)
    time.sleep(0.3)
    process.send_signal(ending)
    out, err = process.communicate(timeout=60)
    from tierod.io.readers.frames import heard
    from tierod.io.readers.mdf import open_mdf

    assert heard(open_mdf(log)).frames >= 0.99 * len(frames)
    if ending == signal.SIGTERM:
        assert process.returncode in (0, 1, 2), err
        assert json.loads(out.splitlines()[-1])["event"] == "end"
        assert log.read_bytes()[:3] == b"MDF"
    else:
        assert log.read_bytes()[:7] == b"UnFinMF"


def test_the_view_shows_verdicts_and_bars(tmp_path):
    from rich.console import Console

    from tierod.live.view import picture, sparkline

    drive, inbox, _ = started(tmp_path, Outputs())
    driven(drive, inbox, frames_of_drive(tmp_path, 6.0))
    console = Console(width=150, file=io.StringIO(), record=True)
    console.print(picture(drive))
    text = console.export_text()
    assert "friction" in text
    assert "all signals are there" in text
    assert sparkline([0.0, 1.0, np.nan, 7.0]) == "▁▂ █"
    assert sparkline([np.nan]) == ""


def test_a_drive_that_nothing_could_judge_is_not_healthy(tmp_path):
    run, inbox, events = started(tmp_path, Outputs())
    for step in range(500):
        now = START + 0.01 * step
        inbox.put(Frame(now, 0x7, 1, bytes(8)))
        run.tick(now, now)
    run.close()
    assert run.exit_code == 2
    assert events[-1]["not_run"] == {"friction": "no received frame is in the databases"}


@pytest.mark.skipif(sys.platform != "linux", reason="the option is of Linux")
def test_every_channel_of_multicast_gives_the_frames_of_its_own_group(multicast):
    inboxes = [queue.SimpleQueue(), queue.SimpleQueue()]
    channels = ("239.74.163.78", "239.74.163.79")
    receivers = [Receiver(1, Address("udp_multicast", name), inboxes[place]) for place, name in enumerate(channels)]
    for receiver in receivers:
        receiver.start()
    with can.Bus(interface="udp_multicast", channel=channels[0]) as bus:
        bus.send(can.Message(arbitration_id=1, data=b"1", is_extended_id=False))
    assert inboxes[0].get(timeout=5.0).identifier == 1
    for receiver in receivers:
        receiver.end()
    assert inboxes[1].empty()


def test_a_signal_that_comes_and_goes_is_said_each_time(tmp_path):
    drive, inbox, events = started(tmp_path, Outputs())
    frames = [
        each for each in frames_of_drive(tmp_path, 30.0)
        if each.identifier != 0x200 or not (6 < each.time - START < 10 or 18 < each.time - START < 22)
    ]  # fmt: skip
    driven(drive, inbox, frames)
    said = [(each["event"], each["signal"]) for each in events if each.get("signal") == "yaw_rate"]
    assert said == [("problem", "yaw_rate"), ("signal", "yaw_rate")] * 2


def test_the_fault_memory_of_another_car_does_not_keep_from_judging(tmp_path):
    with FaultMemory.changing(tmp_path / "car.json", "another-car") as memory:
        memory.begin_cycle()
        memory.end_cycle()
    drive, inbox, events = started(tmp_path, Outputs(), memory=tmp_path / "car.json")
    driven(drive, inbox, frames_of_drive(tmp_path, 8.0))
    drive.close()
    problems = [each["text"] for each in events if each["event"] == "problem"]
    assert len([each for each in problems if "monitoring goes on without the fault memory" in each]) == 1
    assert next(each for each in events if each["event"] == "end")["verdicts"]["friction"]


pytest.importorskip("cantools")


def test_several_readers_get_all_events_and_late_ones_the_newest_state():
    source = Events()
    source(line("begin", {"origin": 1.0}))
    source(line("state", {"time": 1.0}))
    source(line("state", {"time": 2.0}))
    first, second = source.read(), source.read()
    assert [next(first) for _ in range(2)] == [next(second) for _ in range(2)]
    threading.Timer(0.05, lambda: source(line("mark", {"text": "here"}))).start()
    assert next(first)["text"] == next(second)["text"] == "here"
    source.close()
    assert list(first) == list(second) == []


def test_databases_that_disagree_are_named(tmp_path):
    first = database_file(tmp_path)
    second = tmp_path / "other.dbc"
    second.write_text(DBC.replace("yaw_rate : 0|16@1- (0.0001,0)", "yaw_rate : 0|16@1- (0.0002,0)"))
    databases = {path: load_databases([path]) for path in (first, second)}
    text = disagreements(databases)
    assert "0x200 (yaw_rate differs in bits, sign, factor, offset or unit; other.dbc is used, not car.dbc)" in text
    assert disagreements({first: databases[first], tmp_path / "copy.dbc": databases[first]}) == ""


def test_a_log_that_is_there_is_kept_and_a_cut_drive_is_named(tmp_path):
    log = FrameLog(tmp_path / "log.mf4", START)
    log.append(frames_of_drive(tmp_path, 1.0))
    before = (tmp_path / "log.mf4").read_bytes()
    assert is_unfinished(tmp_path / "log.mf4")
    run, inbox, events = started(tmp_path, Outputs(tmp_path / "log.mf4"), tmp_path / "car.json")
    driven(run, inbox, frames_of_drive(tmp_path, 4.0))
    run.close()
    assert (tmp_path / "log.mf4").read_bytes() == before
    assert not is_unfinished(tmp_path / "log-2.mf4")
    text = next(each["text"] for each in events if each["event"] == "problem")
    assert "log.mf4 exists already; this drive is written to" in text
    assert "--memory" in text
