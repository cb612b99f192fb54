"""Judging while driving gives what `diagnose` gives for the log of the drive."""

import math
import random
import resource
import signal

import pytest

from attack.crowds import at_once
from live_drives import CAR, DBC, START, driven, frames_of_drive, messages, started
from tierod.io.readers.dbc import load_databases
from tierod.live.clock import DriveClock, Frame
from tierod.live.engine import Engine
from tierod.live.judge import Plan
from tierod.live.log import FrameLog
from tierod.live.outputs import Outputs
from tierod.monitors.diagnose import diagnose

pytest.importorskip("cantools")
pytest.importorskip("asammdf")

MONITORS = ("friction", "sideslip")


def run(folder, frames, monitors=MONITORS, log=True):
    events = []
    engine = Engine(
        messages(folder), None, monitors, Plan(CAR), lambda kind, each: events.append((kind, dict(each))),
        log=FrameLog(folder / "log.mf4", START) if log else None,
    )  # fmt: skip
    for begin in range(0, len(frames), 50):
        part = frames[begin : begin + 50]
        engine.take(part, part[-1].time, part[-1].time)
        if engine.due:
            engine.judge()
    return engine, {judge.name: diagnosis for judge, diagnosis, _ in engine.finish()}, events


def same(live, offline):
    mine, other = live.findings[0], offline.findings[0]
    assert (mine.status, mine.since, mine.headline) == (other.status, other.since, other.headline)
    assert (mine.estimate is None) == (other.estimate is None)
    if mine.estimate is not None:
        # Mean squares, summed over other pieces.
        assert mine.estimate.value == pytest.approx(other.estimate.value, rel=1e-12)
        assert mine.estimate.standard_deviation == pytest.approx(other.estimate.standard_deviation, rel=1e-12)
    assert live.parameter_effects == offline.parameter_effects


def test_live_and_offline_agree(tmp_path):
    frames = frames_of_drive(tmp_path)
    engine, found, _ = run(tmp_path, frames)
    assert set(found) == set(MONITORS)
    assert [str(each.status) for each in engine.shown()] == ["not ready", "estimated"]
    for name, live in found.items():
        same(live, diagnose(tmp_path / "log.mf4", CAR, name, dbc=tmp_path / "car.dbc"))


def test_frames_that_come_out_of_order_change_nothing(tmp_path):
    frames = frames_of_drive(tmp_path, 8.0)
    _, straight, _ = run(tmp_path, frames, ("friction",), log=False)
    chance, shuffled = random.Random(4), list(frames)
    for place in range(0, len(shuffled) - 8, 8):
        part = shuffled[place : place + 8]
        chance.shuffle(part)
        shuffled[place : place + 8] = part
    shuffled.sort(key=lambda frame: frame is not frames[0])
    engine, mixed, _ = run(tmp_path, shuffled, ("friction",), log=False)
    assert engine.clock.late > 100
    same(mixed["friction"], straight["friction"])


def test_a_message_that_falls_silent_is_named(tmp_path):
    frames = [
        each for each in frames_of_drive(tmp_path, 12.0) if each.identifier != 0x200 or not 6 < each.time - START < 9
    ]
    _, _, events = run(tmp_path, frames, ("friction",), log=False)
    assert any(
        kind == "silence" and "0x200 on CAN1: not received for 2.9" in each["text"] for kind, each in events
    ) or any(kind == "silence" and "0x200 on CAN1: not received for 3" in each["text"] for kind, each in events)


def test_a_message_that_begins_later_than_others_is_waited_for(tmp_path):
    frames = [each for each in frames_of_drive(tmp_path, 14.0) if each.identifier != 0x200 or each.time - START > 6.3]
    engine, found, events = run(tmp_path, frames)
    assert set(found) == set(MONITORS)
    assert [each.reason for each in engine.shown()] == ["", ""]
    texts = [each.get("reason", "") for kind, each in events if kind == "verdict"]
    assert any(text for text in texts), "before, it said what was missing"


def test_a_monitor_that_cannot_run_says_why_and_the_others_go_on(tmp_path):
    frames = frames_of_drive(tmp_path, 6.0)
    engine, found, events = run(tmp_path, frames, ("friction", "motor-angle"), log=False)
    assert set(found) == {"friction"}
    reasons = {each.monitor: each.reason for each in engine.shown()}
    assert "motor" in reasons["motor-angle"]
    assert any(kind == "verdict" and each["monitor"] == "motor-angle" for kind, each in events)


def test_a_disk_that_fills_up_does_not_end_the_monitoring(tmp_path, monkeypatch):
    from tierod.core.errors import OutputError

    def full(self, frames):
        raise OutputError("the log is full")

    monkeypatch.setattr(FrameLog, "append", full)
    engine, found, events = run(tmp_path, frames_of_drive(tmp_path, 6.0), ("friction",))
    assert ("problem", {"text": "the log is full; monitoring goes on without a log"}) in events
    assert engine.log is None
    assert "friction" in found


def test_a_monitor_that_measures_its_first_minute_waits_for_it(tmp_path):
    frames = frames_of_drive(tmp_path, 66.0)
    _, found, events = run(tmp_path, frames, ("driver-torque",))
    assert any(each.get("reason") == "listens for 60 s before it judges" for _, each in events)
    offline = diagnose(tmp_path / "log.mf4", CAR, "driver-torque", dbc=tmp_path / "car.dbc")
    same(found["driver-torque"], offline)
    for name in ("hand_torque", "hands_on"):
        live = found["driver-torque"].traces.get(name)
        if live is not None:
            assert live.mean.tolist() == pytest.approx(offline.traces[name].mean.tolist(), nan_ok=True, rel=1e-12)


CALENDAR = 1_700_000_000.0


def placed(clock, time, bus=1, came=None, data=b"x"):
    return clock.placed(Frame(time, 7, bus, data), time if came is None else came, CALENDAR)


def test_time_counts_from_the_whole_second_of_the_first_stamp():
    clock = DriveClock()
    assert placed(clock, CALENDAR + 0.75).time == 0.75
    assert clock.origin == CALENDAR


def test_frames_out_of_order_keep_their_stamps_and_are_counted():
    clock = DriveClock()
    times = [placed(clock, 10.0 + at).time for at in (0.0, 0.2, 0.1, 0.3)]
    assert times == [0.0, 0.1999999999999993, 0.09999999999999964, 0.3000000000000007]
    assert (clock.late, clock.jumps) == (1, 0)


def test_a_clock_that_jumps_back_goes_on_by_the_time_of_the_computer():
    clock = DriveClock()
    placed(clock, 100.0, came=5.0)
    assert math.isclose(placed(clock, 40.0, came=5.01).time, 0.01, abs_tol=1e-9)
    assert math.isclose(placed(clock, 40.02, came=5.03).time, 0.03, abs_tol=1e-9)
    assert clock.jumps == 1


def test_a_clock_that_jumps_ahead_is_bridged_and_a_pause_is_not():
    clock = DriveClock()
    placed(clock, 100.0, came=5.0)
    assert math.isclose(placed(clock, 160.0, came=65.0).time, 60.0)
    assert clock.jumps == 0
    assert math.isclose(placed(clock, 9000.0, came=65.01).time, 60.01)
    assert clock.jumps == 1


def test_doubled_frames_are_counted_and_a_stamp_that_is_no_number_is_left_out():
    clock = DriveClock()
    placed(clock, 1.0)
    placed(clock, 1.0)
    placed(clock, 1.0, data=b"y")
    assert clock.doubled == 1
    assert placed(clock, math.nan) is None


pytest.importorskip("cantools")
pytest.importorskip("asammdf")

HEAVY = """
BO_ 2566844926 EBC1: 8 ECU
 SG_ yaw_rate : 0|16@1+ (0.0001,-3) [-3|3] "rad/s" ECU
 SG_ vehicle_speed : 16|16@1+ (0.00390625,0) [0|251] "km/h" ECU

BO_ 513 Switched: 8 ECU
 SG_ which M : 0|4@1+ (1,0) [0|15] "" ECU
 SG_ lateral_acceleration m1 : 8|16@1- (0.001,0) [0|0] "m/s**2" ECU

BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_ "ProtocolType" STRING ;
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_DEF_DEF_ "ProtocolType" "";
BA_ "ProtocolType" "J1939";
BA_ "VFrameFormat" BO_ 2566844926 3;
"""


def as_truck(frames):
    """The second message as one of J1939 from another sender, and one that is multiplexed."""
    for frame in frames:
        if frame.identifier != 0x200:
            yield frame
            continue
        yaw, lateral, speed = (int.from_bytes(frame.data[at : at + 2], "little", signed=at < 4) for at in (0, 2, 4))
        words = (yaw + 30_000, round(0.01 * speed * 3.6 * 256.0), 0, 0)
        yield frame._replace(
            # The address of the sender is not that of the database.
            identifier=(2566844926 & ~0xFF) | 0x31,
            data=b"".join(each.to_bytes(2, "little") for each in words),
        )
        other = b"\1" + lateral.to_bytes(2, "little", signed=True) + bytes(5)
        yield frame._replace(identifier=0x201, data=other)
        yield frame._replace(identifier=0x201, data=b"\2" + b"\x55" * 7)


def test_j1939_and_multiplexed_messages_are_judged(tmp_path):
    text = DBC[: DBC.index("BO_ 512")] + HEAVY
    (tmp_path / "truck.dbc").write_text(text)
    frames = list(as_truck(frames_of_drive(tmp_path)))
    engine = Engine(load_databases([tmp_path / "truck.dbc"]), None, ("friction",), Plan(CAR))
    for begin in range(0, len(frames), 40):
        part = frames[begin : begin + 40]
        engine.take(part, part[-1].time, part[-1].time)
        if engine.due:
            engine.judge()
    assert [each.reason for each in engine.shown()] == [""]
    speed = engine.judges[0]._newest.values["vehicle_speed"]
    assert speed == pytest.approx(20.0, abs=0.3)


def test_a_disk_that_fills_up_leaves_whole_records(tmp_path):
    def run_with_little_room(_):
        run, inbox, events = started(tmp_path, Outputs(tmp_path / "log.mf4"))
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
        driven(run, inbox, frames)
        run.close()
        return events

    frames = frames_of_drive(tmp_path, 8.0)
    driven(*started(tmp_path, Outputs())[:2], frames)  # kernels are compiled where there is room
    (events,) = at_once(1, run_with_little_room)
    assert isinstance(events, list), events
    problems = [each["text"] for each in events if each["event"] == "problem"]
    assert any("monitoring goes on without a log" in each for each in problems), problems
    assert events[-1]["event"] == "end"
    from tierod.io.readers.frames import heard
    from tierod.io.readers.mdf import open_mdf

    assert heard(open_mdf(tmp_path / "log.mf4")).frames > 500
