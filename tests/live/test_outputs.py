"""What a drive gives beside its verdicts: events for several readers, a log of its own."""

import asyncio
import threading

import pytest

from live_drives import DBC, START, database_file, driven, frames_of_drive, started
from tierod.io.readers.dbc import load_databases
from tierod.live.decoding import disagreements
from tierod.live.events import Events, line
from tierod.live.log import FrameLog, is_unfinished
from tierod.live.outputs import Outputs

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
