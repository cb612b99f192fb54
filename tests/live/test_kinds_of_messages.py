"""Multiplexed and J1939 signals live, an interrupted bus, and a full disk."""

import resource
import signal

import pytest

from attack.crowds import at_once
from live_drives import CAR, DBC, START, driven, frames_of_drive, started
from tierod.io.readers.dbc import load_databases
from tierod.live.engine import Engine
from tierod.live.judge import Plan
from tierod.live.outputs import Outputs

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


def test_a_bus_that_was_off_is_taken_up_again(tmp_path):
    frames = [each for each in frames_of_drive(tmp_path) if not 6.0 < each.time - START < 6.6]
    run, inbox, _ = started(tmp_path, Outputs())
    driven(run, inbox, frames)
    assert run.engine.missing == ()
    assert run.engine.clock.jumps == 0


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
