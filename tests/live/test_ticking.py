"""Ticks: single frames decode as arrays do, and a block stepped tick by tick sees what the pieces see."""

import random

import numpy as np
import pytest

from live_drives import DBC, START, frames_of_drive
from tierod.io.readers.dbc import Rows, channel_of, described, load_databases
from tierod.io.readers.frames import EXTENDED
from tierod.io.readers.log import Heard
from tierod.live.bound import bound
from tierod.live.engine import Engine
from tierod.live.frame import Frame, frames_of
from tierod.live.judge import Plan
from tierod.monitors.harness.over_time import OverTime
from tierod.monitors.harness.run import Run, fitting
from tierod.monitors.registry import MONITORS
from tierod.vehicles import load

pytest.importorskip("cantools")

CAR = load("midsize-eps")

HEAD = 'VERSION ""\nNS_ :\nBS_:\nBU_: ECU\n'
KINDS = """BO_ 256 Mixed: 12 ECU
 SG_ little : 3|13@1+ (0.25,-7) [0|0] "" ECU
 SG_ negative : 17|11@1- (0.001,0) [0|0] "" ECU
 SG_ big : 30|14@0+ (0.5,1) [0|0] "" ECU
 SG_ big_negative : 47|16@0- (0.1,0) [0|0] "" ECU
 SG_ whole : 0|64@1+ (1,0) [0|0] "" ECU
 SG_ real : 64|32@1- (1,0) [0|0] "" ECU
 SG_ across : 5|60@1+ (1,0) [0|0] "" ECU

BO_ 512 Switched: 8 ECU
 SG_ which M : 0|4@1+ (1,0) [0|15] "" ECU
 SG_ first m0 : 8|16@1- (0.01,0) [0|0] "" ECU
 SG_ second m1 : 8|16@0+ (0.02,3) [0|0] "" ECU

BO_ 2566844926 Heavy: 8 ECU
 SG_ speed : 0|16@1+ (0.00390625,0) [0|251] "km/h" ECU
 SG_ switch : 16|2@1+ (1,0) [0|3] "" ECU
 SG_ percent : 24|8@1+ (0.4,0) [0|100] "%" ECU

BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_ "ProtocolType" STRING ;
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_DEF_DEF_ "ProtocolType" "";
BA_ "ProtocolType" "J1939";
BA_ "VFrameFormat" BO_ 2566844926 3;
SIG_VALTYPE_ 256 real : 1;
"""


def test_a_frame_decodes_as_the_array_does(tmp_path):
    (tmp_path / "kinds.dbc").write_text(HEAD + KINDS)
    database = load_databases([tmp_path / "kinds.dbc"])
    assert any(each.protocol == "j1939" for each in database)
    chance = random.Random(11)
    for message in database:
        identifier = message.frame_id | (EXTENDED if message.is_extended_frame else 0)
        lengths = [chance.choice((message.length, message.length, 4, 1)) for _ in range(300)]
        datas = [bytes(chance.choice((0xFF, 0xFE, 0, 1, chance.randrange(256))) for _ in range(n)) for n in lengths]
        frames = frames_of([Frame(0.01 * n, identifier, 1, data) for n, data in enumerate(datas)], 0.0)
        known = described(Heard({(0, identifier): len(datas)}, ("CAN1",), len(datas)), [message])
        rows = Rows.of(frames, np.arange(len(datas)))
        for item in message.signals:
            single = [bound(message, item)(data) for data in datas]
            kept = [n for n, each in enumerate(single) if each is not None]
            whole = channel_of(item.name, known.found[0, identifier], item, rows)
            np.testing.assert_array_equal(whole.time, 0.01 * np.array(kept))
            np.testing.assert_array_equal(whole.values, np.array([single[n] for n in kept]))


def ticked(folder, frames, names, dbc=DBC, at_once=20):
    """An engine after a drive, and what each of its tickers showed after each step by its time."""
    (folder / "car.dbc").write_text(dbc)
    engine = Engine(load_databases([folder / "car.dbc"]), None, names, Plan(CAR))
    seen = {name: {} for name in names}
    for begin in range(0, len(frames), at_once):
        part = frames[begin : begin + at_once]
        engine.take(part, part[-1].time, part[-1].time)
        for name, ticker in engine.ticks.tickers.items():
            if ticker.live and ticker.steps:
                seen[name][round((ticker.due - ticker._run.start) * ticker._run.monitor.rate) - 1] = ticker.values()
        if engine.due:
            engine.judge()
    return engine, seen


def over_time(name):
    """Every sample that a run over the same drive estimates."""
    recording = quantised()
    definition, variant = fitting(MONITORS[name], MONITORS[name].variants[MONITORS[name].default], recording, False)
    kept = OverTime()
    run = Run(definition, variant, CAR, kept=kept)
    run.add(recording)
    run.finish()
    return kept


_FOLDER = {}


def quantised():
    """The drive as its frames carry it."""
    from tierod.io.readers import read
    from tierod.live.log import FrameLog

    folder = _FOLDER["path"]
    log = FrameLog(folder / "whole.mf4", START)
    log.append([frame._replace(time=frame.time - START) for frame in frames_of_drive(folder)])
    log.finish()
    return read(folder / "whole.mf4", dbc=folder / "car.dbc")


@pytest.mark.parametrize("name", ["friction", "sideslip"])
def test_every_tick_gives_what_the_whole_recording_gives(tmp_path, name):
    pytest.importorskip("asammdf")
    _FOLDER["path"] = tmp_path
    engine, seen = ticked(tmp_path, frames_of_drive(tmp_path), (name,))
    ticker = engine.ticks.tickers[name]
    assert ticker.corrected == 0
    assert ticker.steps > 700
    kept = over_time(name)
    shown = {each: np.concatenate(values) for each, values in kept._values.items()}
    assert len(seen[name]) > 80
    for step, values in seen[name].items():
        for each, value in values.items():
            np.testing.assert_equal(value, shown[each][step], err_msg=f"{each} at step {step}")


def test_ticks_make_the_rate_from_the_angle_and_wait_for_a_second_bus(tmp_path):
    dbc = DBC.replace("SG_ steering_wheel_rate", "SG_ unknown_quantity")
    frames = [each._replace(bus=2) if each.identifier == 0x200 else each for each in frames_of_drive(tmp_path)]
    # The second bus is delivered late, as a receiver of its own does.
    frames.sort(key=lambda frame: frame.time + (0.012 if frame.bus == 2 else 0.0))
    engine, _ = ticked(tmp_path, frames, ("friction",), dbc, at_once=3)
    assert engine.ticks.tickers["friction"].corrected == 0
    assert engine.ticks.tickers["friction"].steps > 700
    assert engine.shown()[0].ticking


def test_a_late_frame_is_made_good_by_the_next_piece(tmp_path):
    frames = frames_of_drive(tmp_path)
    late = [frame for place, frame in enumerate(frames) if place % 200 == 150]
    order = sorted(frames, key=lambda frame: frame.time + (0.1 if frame in late else 0.0))
    engine, _ = ticked(tmp_path, order, ("friction",))
    straight, _ = ticked(tmp_path, frames, ("friction",))
    assert engine.ticks.tickers["friction"].corrected > 2
    assert engine.tally.too_late == 0
    for each in (engine, straight):
        each.judge(rest=True)
    mine, other = (each.judges[0].run.session.memory for each in (engine, straight))
    np.testing.assert_array_equal(mine.values, other.values)


def test_a_verdict_comes_with_the_tick_and_not_with_the_piece(tmp_path):
    events = []
    (tmp_path / "car.dbc").write_text(DBC)
    engine = Engine(
        load_databases([tmp_path / "car.dbc"]), None, ("friction",), Plan(CAR),
        lambda kind, content: events.append((kind, dict(content))),
    )  # fmt: skip
    frames = frames_of_drive(tmp_path, 8.0)
    changed = None
    for begin in range(0, len(frames), 10):
        part = frames[begin : begin + 10]
        engine.take(part, part[-1].time, part[-1].time)
        if changed is None and engine.clock.latest > 6.0 and engine.ticks.tickers:
            # The block's next statement is taken for another one: the piece of this time is not judged before 7.5 s.
            ticker = engine.ticks.tickers["friction"]
            ticker.status = ticker.status._replace(status="other")
            engine._statuses["friction"] = ("other", "")
            changed, before = engine.clock.latest, len(events)
        elif changed is not None and len(events) > before:
            break
        elif engine.due:
            engine.judge()
    kind, content = events[before]
    assert kind == "verdict"
    assert content["time"] - changed < 0.021


def test_ticks_wait_after_a_long_silence(tmp_path):
    first = frames_of_drive(tmp_path, 8.0)
    frames = [*first, *(frame._replace(time=frame.time + 60.0) for frame in first)]
    engine, _ = ticked(tmp_path, frames, ("friction",))
    assert engine.ticks.tickers["friction"].live
    assert engine.ticks.tickers["friction"].steps < 1500
