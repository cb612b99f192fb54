"""Whole drives: buses, memory, report, ignition, lost buses, kills."""

import io
import json
import queue
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from live_drives import CAR, START, database_file, driven, frames_of_drive, started
from tierod.core.errors import InputError, ParameterError
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.live.buses import Address, ProcessReceiver, Receiver, open_bus
from tierod.live.clock import Frame, Notice
from tierod.live.events import Socket, line
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


def test_a_bus_that_falls_silent_in_a_drive_names_its_end(tmp_path):
    drive, inbox, events = started(tmp_path, Outputs(silence=10.0))
    frames = frames_of_drive(tmp_path, 5.0)
    driven(drive, inbox, frames)
    drive.tick(frames[-1].time + 6.0, frames[-1].time + 6.0)
    drive.close()
    texts = [each["text"] for each in events if each["event"] == "problem"]
    assert "no frame was received for 5 s; the drive ends after 10 s of silence" in texts
    assert not any("ignition" in text for text in texts)


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


@pytest.mark.parametrize(
    ("address", "error", "sentence"),
    [
        (Address("socketcam", "can0"), ParameterError, "no interface 'socketcam'; did you mean 'socketcan'"),
        (Address("socketcan", "can77"), InputError, "the bus socketcan can77 cannot be opened"),
        (Address("kvaser", "0"), InputError, "the bus kvaser 0 cannot be opened"),
    ],
)
def test_a_bus_that_cannot_be_opened(address, error, sentence):
    with pytest.raises(error, match=sentence):
        open_bus(address)


def test_judging_in_a_thread_gives_the_same(tmp_path, monkeypatch):
    from tierod.live.engine import Judging

    frames = frames_of_drive(tmp_path, 10.0)
    straight, inbox, _ = started(tmp_path, Outputs(), None, None, ["friction", "sideslip"])
    driven(straight, inbox, frames)
    beside, inbox, _ = started(tmp_path, Outputs(), None, None, ["friction", "sideslip"])
    beside._judging = Judging(threaded=True)
    work, overlapped = beside.engine.work, []

    def slow(piece):
        before = beside.engine.tally.frames
        time.sleep(0.15)
        work(piece)
        overlapped.append(beside.engine.tally.frames - before)

    monkeypatch.setattr(beside.engine, "work", slow)
    for begin in range(0, len(frames), 20):
        driven(beside, inbox, frames[begin : begin + 20])
        time.sleep(0.01)
    assert max(overlapped) > 50, "ticks took frames while a piece was judged"
    first, second = straight.engine.finish(), None
    beside._judging.ended(beside.engine, wait=True)
    second = beside.engine.finish()
    for (judge, one, _), (other, two, _) in zip(first, second, strict=True):
        assert one.findings[0].headline == two.findings[0].headline
        np.testing.assert_array_equal(judge.run.session.memory.values, other.run.session.memory.values)
    beside._judging.close()


def test_a_process_says_that_its_bus_cannot_be_opened():
    with pytest.raises(ParameterError, match="did you mean 'socketcan'"):
        ProcessReceiver(1, Address("socketcam", "can0"), queue.SimpleQueue())


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


def _sent(frames, until):
    with can.Bus(interface="udp_multicast", channel=CHANNEL) as bus:
        for frame in frames:
            if not until(frame):
                return
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
        _sent(frames[:20], lambda frame: True)
    _sent(frames, lambda frame: True)
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


def test_a_terminal_is_reported_how_the_drive_ended(tmp_path, capsys):
    from tierod.cli.live import _in_terminal

    run, inbox, _ = started(tmp_path, Outputs())
    frames = frames_of_drive(tmp_path, 4.0)
    for frame in frames:
        inbox.put(frame)

    def enough(now):
        run.ended |= run.engine.tally.frames >= len(frames)

    run.looking.append(enough)
    _in_terminal(run)
    assert '"event": "end"' in capsys.readouterr().out


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


def test_an_ignition_that_no_database_has_is_refused(tmp_path, capsys):
    from tierod.cli import main

    database_file(tmp_path)
    words = ["live", "--interface", "virtual", "--channel", "a", "--vehicle", "midsize-eps"]
    assert main([*words, "--dbc", str(tmp_path / "car.dbc"), "--ignition", "ESP.ignitin"]) == 3
    assert "did you mean 'ESP.ignition'?" in capsys.readouterr().err


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


def test_the_view_and_the_state_say_how_late_a_verdict_may_be(tmp_path):
    from rich.console import Console

    from tierod.live.view import picture

    drive, inbox, _ = started(tmp_path, Outputs())
    driven(drive, inbox, frames_of_drive(tmp_path, 8.0))
    (shown,) = drive.state()["monitors"]
    assert shown["delay"] == pytest.approx(0.8)
    console = Console(width=160, file=io.StringIO())
    console.print(picture(drive))
    assert "(up to 0.8 s late)" in console.file.getvalue()


@pytest.mark.skipif(sys.platform != "linux", reason="the option is of Linux")
def test_a_frame_of_another_group_that_came_before_the_option_is_dropped(multicast):
    from tierod.live.buses import _own_group_alone

    channels = ("239.74.163.78", "239.74.163.79")
    with (
        can.Bus(interface="udp_multicast", channel=channels[0]) as bus,
        can.Bus(interface="udp_multicast", channel=channels[1]) as other,
    ):
        other.send(can.Message(arbitration_id=2, data=b"2", is_extended_id=False))
        time.sleep(0.05)
        _own_group_alone(bus)
        assert bus.recv(0.05) is None
