"""Judging while driving gives what `diagnose` gives for the log of the drive."""

import random

import pytest

from live_drives import START, frames_of_drive, messages
from tierod.live.clock import Gap, sentences
from tierod.live.engine import Engine
from tierod.live.judge import Plan
from tierod.live.log import FrameLog
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load

pytest.importorskip("cantools")
pytest.importorskip("asammdf")

CAR = load("midsize-eps")
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


def test_states_agree_to_the_last_bit(tmp_path):
    frames = frames_of_drive(tmp_path)
    _, found, _ = run(tmp_path, frames, ("friction",))
    offline = diagnose(tmp_path / "log.mf4", CAR, "friction", dbc=tmp_path / "car.dbc")
    for name, trace in offline.traces.items():
        live = found["friction"].traces[name]
        assert live.mean.tolist() == pytest.approx(trace.mean.tolist(), nan_ok=True, rel=1e-12, abs=1e-300), name


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


def test_lost_frames_are_counted(tmp_path):
    frames = [frame for place, frame in enumerate(frames_of_drive(tmp_path, 10.0)) if place % 97]
    engine, _, _ = run(tmp_path, frames, ("friction",), log=False)
    assert engine.gaps.lost == pytest.approx(2000 / 97, abs=4)


def test_a_message_that_falls_silent_is_named(tmp_path):
    frames = [
        each for each in frames_of_drive(tmp_path, 12.0) if each.identifier != 0x200 or not 6 < each.time - START < 9
    ]
    _, _, events = run(tmp_path, frames, ("friction",), log=False)
    assert any(
        kind == "silence" and "0x200 on CAN1: not received for 2.9" in each["text"] for kind, each in events
    ) or any(kind == "silence" and "0x200 on CAN1: not received for 3" in each["text"] for kind, each in events)


def test_messages_that_fall_silent_together_are_one_sentence():
    gaps = [Gap(identifier, "CAN1", 2.0 + identifier) for identifier in range(1, 8)] + [Gap(0x100, "CAN2", 3.0)]
    assert sentences(gaps) == [
        "0x001, 0x002, 0x003, 0x004 and 3 more on CAN1: not received for 9 s",
        "0x100 on CAN2: not received for 3 s",
    ]


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


def test_a_bus_without_a_known_message(tmp_path):
    strange = [frame._replace(identifier=0x99) for frame in frames_of_drive(tmp_path, 4.0)]
    engine, found, _ = run(tmp_path, strange, ("friction",), log=False)
    assert found == {}
    assert engine.decoder.known is None


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


def test_a_drive_that_is_shorter_than_what_a_monitor_listens_to_is_judged_at_its_end(tmp_path):
    _, found, _ = run(tmp_path, frames_of_drive(tmp_path, 8.0), ("driver-torque",))
    same(found["driver-torque"], diagnose(tmp_path / "log.mf4", CAR, "driver-torque", dbc=tmp_path / "car.dbc"))


def test_signals_are_not_missing_where_a_piece_takes_long_to_judge(tmp_path):
    frames = frames_of_drive(tmp_path, 10.0)
    engine = Engine(messages(tmp_path), None, ("friction",), Plan(CAR), lambda kind, each: None)
    piece = None
    for begin in range(0, len(frames), 50):
        part = frames[begin : begin + 50]
        engine.take(part, part[-1].time, part[-1].time)
        if piece is None and engine.due:
            piece = engine.cut()
    engine.work(piece)  # seconds later, as where kernels were compiled first
    engine.settle(piece)
    assert engine.missing == ()
    assert max(engine.ages.values()) < 0.4
