"""What a drive gives beside its verdicts: an MCAP log, events for several readers."""

import asyncio
import json
import threading

import numpy as np
import pytest

from live_drives import DBC, START, database_file, driven, frames_of_drive, started
from tierod.core.recording import Channel
from tierod.io.readers import read
from tierod.io.readers.dbc import load_databases
from tierod.live.agreement import disagreements
from tierod.live.drive import Outputs
from tierod.live.events import Events, line
from tierod.live.log import FrameLog, is_unfinished
from tierod.live.mcap_log import McapLog

pytest.importorskip("cantools")
mcap = pytest.importorskip("mcap")


def logged(path):
    from mcap.reader import make_reader

    found = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            found.setdefault(channel.topic, []).append((schema, message.log_time, json.loads(message.data)))
    return found


def test_a_drive_as_mcap(tmp_path):
    outputs = Outputs(tmp_path / "log.mf4", mcap=tmp_path / "drive.mcap")
    run, inbox, _ = started(tmp_path, outputs)
    frames = frames_of_drive(tmp_path, 8.0)
    driven(run, inbox, frames)
    run.mark()
    run.close()
    found = logged(tmp_path / "drive.mcap")
    rates = [value["value"] for _, _, value in found["/signals/yaw_rate"]]
    raw = [int.from_bytes(each.data[:2], "little", signed=True) for each in frames if each.identifier == 0x200]
    np.testing.assert_allclose(rates, 1e-4 * np.array(raw), atol=1e-12)
    schema, stamp, _ = found["/signals/yaw_rate"][0]
    assert json.loads(schema.data)["properties"]["value"]["unit"] == "rad/s"
    first = next(each.time for each in frames if each.identifier == 0x200)
    assert stamp == pytest.approx(first * 1e9, abs=1e6)
    assert 70 <= len(found["/estimates/friction"]) <= 80
    assert "friction_torque" in found["/estimates/friction"][-1][2]
    schema, _, entry = found["/findings"][0]
    assert schema.name == "foxglove.Log"
    assert entry["name"] == "friction"
    assert any(each["message"] == "mark" for _, _, each in found["/findings"])


def test_findings_that_are_said_late_keep_their_time_and_leave_the_log_readable(tmp_path):
    log = McapLog(tmp_path / "drive.mcap", START)
    log.finding(4.3, 2, "sideslip", "healthy")
    log.finding(3.6, 2, "friction", "not ready")
    log.finish()
    (_, first, _), (_, second, entry) = logged(tmp_path / "drive.mcap")["/findings"]
    assert first == second
    assert entry["timestamp"] == {"sec": int(START) + 3, "nsec": pytest.approx(6e8, abs=1e3)}
    assert len(read(tmp_path / "drive.mcap")["findings.level"].time) == 2


def test_an_mcap_log_that_was_cut_off_can_be_read(tmp_path):
    log = McapLog(tmp_path / "drive.mcap", START)
    times = np.arange(6000) / 100.0
    for part in np.split(times, 60):
        log.signals([Channel("yaw_rate", part, np.sin(part), "rad/s")])
    (tmp_path / "cut.mcap").write_bytes((tmp_path / "drive.mcap").read_bytes())
    log.finish()
    found = read(tmp_path / "cut.mcap")
    (name,) = [each for each in found.channels if "yaw_rate" in each]
    assert len(found[name].time) > 5900 - 400
    np.testing.assert_allclose(found[name].values, np.sin(times[: len(found[name].time)]))


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


def test_a_slow_reader_loses_the_oldest_events_only():
    source = Events(most=3)
    reader = source.read()
    source(line("state", {"time": 0.0}))
    next(reader)
    for number in range(10):
        source(line("mark", {"text": str(number)}))
    source.close()
    assert [each["text"] for each in reader] == ["7", "8", "9"]


def test_a_coroutine_reads_events():
    source = Events()

    async def first_two():
        found = []
        async for event in source.subscribed():
            found.append(event["event"])
            if len(found) == 2:
                break
        return found

    source(line("begin", {}))
    threading.Timer(0.3, lambda: source(line("mark", {}))).start()
    assert asyncio.run(first_two()) == ["begin", "mark"]
    assert source._queues == []


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
