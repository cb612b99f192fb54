import json
import os
import random
import resource
import signal
import time

import numpy as np
import pytest

from diagnosis.memories import code, drive, table
from tierod.core.errors import InputError, OutputError
from tierod.core.processes import alone
from tierod.diagnosis.entry import CodeStatus
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.store import digest_of

CODES = table(**{f"c{k}": code(k) for k in range(16)})


def confirmed(memory):
    return {name for name, entry in memory.entries.items() if entry.status & CodeStatus.CONFIRMED}


def test_what_is_written_is_read_again(tmp_path):
    path = tmp_path / "memory.json"
    memory = FaultMemory.opened(path, "car", CODES)
    drive(memory, {"c1": (-1.0, 5.0, 1.0), "c2": -1.0})
    again = FaultMemory.opened(path, "car", CODES)
    assert again.entries == memory.entries
    assert (again.cycles, again.date, again.open) == (1, "2026-01-01", False)
    assert [each.name for each in tmp_path.iterdir()] == ["memory.json"]


def test_a_cycle_that_a_lost_program_left_open_is_ended(tmp_path):
    path = tmp_path / "memory.json"
    memory = FaultMemory.opened(path, "car", CODES)
    memory.begin_cycle()
    memory.absorb(np.arange(5.0), {"c1": np.ones(5)})
    again = FaultMemory.opened(path, "car", CODES)
    assert again.open
    again.begin_cycle()
    again.absorb(np.arange(5.0), {"c1": -np.ones(5)})
    again.end_cycle()
    assert confirmed(again) == {"c1"}
    assert not again.entries["c1"].status & CodeStatus.PENDING


def spoilt(path, how):
    text = path.read_text()
    document = json.loads(text)
    if how == "cut":
        path.write_text(text[: len(text) // 2])
    elif how == "empty":
        path.write_text("")
    elif how == "flipped":
        path.write_text(text.replace('"occurrences": 1', '"occurrences": 0'))
    elif how == "version":
        path.write_text(json.dumps({**document, "schema": "tierod.fault-memory/99"}))
    elif how == "table":
        path.write_text(json.dumps({**document, "codes": {**document["codes"], "c1": 5}}))
    elif how == "foreign":
        path.write_text('{"speed": 3}')
    elif how in ("entry", "names"):
        content = document["content"]
        content["entries"] |= {"c1": {"status": 8}} if how == "entry" else {"d1": content["entries"]["c1"]}
        path.write_text(json.dumps({**document, "digest": digest_of(content, "car")}))
    elif how == "recordings":
        content = {**document["content"], "recordings": {"fingerprint": ["one", 1]}}
        path.write_text(json.dumps({**document, "content": content, "digest": digest_of(content, "car")}))
    elif how == "bytes":
        path.write_bytes(b"\xff\xfe\x00")


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ("cut", "damaged: it is not a complete JSON"),
        ("empty", "is no fault memory"),
        ("flipped", "does not match its digest"),
        ("version", "another version"),
        ("table", "another table"),
        ("foreign", "is no fault memory"),
        ("bytes", "is no fault memory"),
        ("entry", "an entry is incomplete"),
        ("recordings", "its recordings are incomplete"),
        ("names", "codes do not match its table"),
    ],
)
def test_a_file_that_does_not_fit_is_refused_and_left_alone(tmp_path, how, says):
    path = tmp_path / "memory.json"
    drive(FaultMemory.opened(path, "car", CODES), {"c1": 1.0})
    spoilt(path, how)
    before = path.read_bytes()
    with pytest.raises(InputError, match=says):
        FaultMemory.opened(path, "car", CODES)
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == before


@pytest.mark.parametrize("value", [float("nan"), 10**400, -(10**400), None, [], 1e308])
@pytest.mark.parametrize(
    "field", ["status", "counter", "verdict", "occurrences", "failed_cycles", "healed", "consequence_of"]
)
def test_an_entry_of_other_kinds_is_refused_though_its_digest_fits(tmp_path, field, value):
    path = tmp_path / "memory.json"
    drive(FaultMemory.opened(path, "car", CODES), {"c1": (-1.0, 5.0, 1.0)})
    document = json.loads(path.read_text())
    document["content"]["entries"]["c1"][field] = value
    path.write_text(json.dumps({**document, "digest": digest_of(document["content"], "car")}))
    with pytest.raises(InputError, match="damaged"):
        FaultMemory.opened(path, "car", CODES)


@pytest.mark.parametrize("field", ["cycle", "date", "instant", "time", "values"])
@pytest.mark.parametrize(
    "value", [float("nan"), -float("inf"), [float("inf")], {"vehicle_speed": [10**400]}, {"x": [1.0]}]
)
def test_a_freeze_frame_of_other_kinds_is_refused_though_its_digest_fits(tmp_path, field, value):
    path = tmp_path / "memory.json"
    drive(FaultMemory.opened(path, "car", CODES), {"c1": (-1.0, 5.0, 1.0)})
    document = json.loads(path.read_text())
    frame = document["content"]["entries"]["c1"]["first"]
    assert set(frame) == {"cycle", "date", "instant", "time", "values"}
    frame[field] = value
    path.write_text(json.dumps({**document, "digest": digest_of(document["content"], "car")}))
    with pytest.raises(InputError, match="damaged"):
        FaultMemory.opened(path, "car", CODES)


def test_the_memory_of_another_vehicle_is_refused_and_left_alone(tmp_path):
    path = tmp_path / "memory.json"
    drive(FaultMemory.opened(path, "car", CODES), {"c1": 1.0})
    with pytest.raises(InputError, match="belongs to the vehicle 'car', not 'truck'.*name that of this vehicle"):
        FaultMemory.opened(path, "truck", CODES)
    assert list(tmp_path.iterdir()) == [path]


def test_a_table_that_has_grown_reads_what_was_written_before(tmp_path):
    path = tmp_path / "memory.json"
    small = table(**{name: CODES.codes[name] for name in ("c1", "c2")})
    drive(FaultMemory.opened(path, "car", small), {"c1": 1.0})
    grown = FaultMemory.opened(path, "car", CODES)
    assert confirmed(grown) == {"c1"}
    drive(grown, {"c5": 1.0})
    assert confirmed(FaultMemory.opened(path, "car", CODES)) == {"c1", "c5"}
    with pytest.raises(InputError, match="another table"):
        FaultMemory.opened(path, "car", small)


def test_a_link_stays_and_what_killed_writers_left_where_it_leads_is_removed(tmp_path):
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "m[1].json", tmp_path / "link.json"
    link.symlink_to(target)
    drive(FaultMemory.opened(link, "car", CODES), {"c1": 1.0})
    left = target.with_name(".m[1].0123456789ab.json")
    left.write_text("half")
    drive(FaultMemory.opened(link, "car", CODES), {"c2": 1.0})
    assert link.is_symlink()
    assert not left.exists()
    assert confirmed(FaultMemory.opened(target, "car", CODES)) == {"c1", "c2"}


def test_a_file_that_appeared_meanwhile_is_not_overwritten(tmp_path):
    path = tmp_path / "memory.json"
    memory = FaultMemory.opened(path, "car", CODES)
    path.write_text('{"mine": 1}')
    with pytest.raises(OutputError, match="not the one that was read"):
        memory.save()
    assert path.read_text() == '{"mine": 1}'


def test_what_could_not_be_written_is_written_once_there_is_room(tmp_path, monkeypatch):
    path = tmp_path / "memory.json"
    memory = FaultMemory.opened(path, "car", CODES)
    memory.begin_cycle()

    def full(_):
        raise OutputError("no space")

    with monkeypatch.context() as patched:
        patched.setattr("tierod.diagnosis.store.replacing", full)
        with pytest.raises(OutputError, match="no space"):
            memory.absorb(np.arange(3.0), {"c1": np.ones(3)})
    memory.end_cycle()
    assert confirmed(FaultMemory.opened(path, "car", CODES)) == {"c1"}


def test_two_programs_do_not_overwrite_each_other(tmp_path):
    path = tmp_path / "memory.json"
    drive(FaultMemory.opened(path, "car", CODES), {"c1": 1.0})
    one, other = (FaultMemory.opened(path, "car", CODES) for _ in range(2))
    drive(one, {"c2": 1.0})
    with pytest.raises(OutputError, match="another program"):
        drive(other, {"c3": 1.0})
    assert confirmed(FaultMemory.opened(path, "car", CODES)) == {"c1", "c2"}


def test_a_change_is_written_as_one_at_its_end_or_not_at_all(tmp_path):
    path = tmp_path / "memory.json"
    with FaultMemory.changing(path, "car", CODES) as memory:
        drive(memory, {"c1": 1.0})
        assert not path.exists()
    before = path.read_bytes()
    with pytest.raises(InputError), FaultMemory.changing(path, "car", CODES) as memory:
        drive(memory, {"no such code": 1.0, "c2": 1.0})
    assert path.read_bytes() == before
    assert FaultMemory.opened(path, "car", CODES).cycles == 1


def test_what_a_change_holds_no_other_program_writes(tmp_path, monkeypatch):
    monkeypatch.setattr(alone.__wrapped__, "__defaults__", (0.0,))
    path = tmp_path / "memory.json"
    other = FaultMemory.opened(path, "car", CODES)
    with FaultMemory.changing(path, "car", CODES) as memory:
        with pytest.raises(OutputError, match="another program has been writing in its folder.*run again"):
            other.begin_cycle()
        drive(memory, {"c1": 1.0})
    assert FaultMemory.opened(path, "car", CODES).cycles == 1


def test_a_recording_that_was_taken_is_refused_until_all_is_cleared(tmp_path):
    path = tmp_path / "memory.json"
    memory = FaultMemory.opened(path, "car", CODES)
    memory.begin_cycle("2026-01-01", "fingerprint")
    memory.end_cycle()
    memory = FaultMemory.opened(path, "car", CODES)
    with pytest.raises(InputError, match="already contains this recording, as operation cycle 1 on 2026-01-01"):
        memory.begin_cycle("2026-01-02", "fingerprint")
    memory.clear("c1")
    with pytest.raises(InputError, match="nothing was changed"):
        memory.begin_cycle("2026-01-02", "fingerprint")
    memory.clear()
    memory.begin_cycle("2026-01-02", "fingerprint")
    assert memory.cycles == 2


def test_of_very_many_recordings_the_latest_are_known(monkeypatch):
    monkeypatch.setattr("tierod.diagnosis.fault_memory.RECORDINGS", 3)
    memory = FaultMemory(CODES, "car")
    for number in range(5):
        memory.begin_cycle("2026-01-01", f"fingerprint {number}")
        memory.end_cycle()
    assert list(memory.recordings) == ["fingerprint 2", "fingerprint 3", "fingerprint 4"]


def test_a_file_of_before_recordings_were_known_is_read(tmp_path):
    path = tmp_path / "memory.json"
    drive(FaultMemory.opened(path, "car", CODES), {"c1": 1.0})
    document = json.loads(path.read_text())
    del document["content"]["recordings"]
    path.write_text(json.dumps({**document, "digest": digest_of(document["content"], "car")}))
    drive(FaultMemory.opened(path, "car", CODES), {"c2": 1.0})
    assert confirmed(FaultMemory.opened(path, "car", CODES)) == {"c1", "c2"}


def child(path, acknowledged, last_byte):
    """Confirm one code after the other and report each once it is safe, until killed."""
    memory = FaultMemory.opened(path, "car", CODES)
    if last_byte is not None:
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_FSIZE, (last_byte, last_byte))
    memory.begin_cycle()
    at = 0.0
    for name in sorted(set(CODES.codes) - confirmed(memory)):
        memory.absorb(at + np.arange(3.0), {name: np.ones(3)}, {"vehicle_speed": np.arange(3.0)})
        os.write(acknowledged, f"{name}\n".encode())
        at += 10.0
    memory.end_cycle()


def killed(path, random_):
    """A child that is killed: at a byte of a file that it writes, or at an instant. What it said was safe."""
    reading, writing = os.pipe()
    by_byte = random_.random() < 0.5
    last_byte = random_.randrange(0, 20_000) if by_byte else None
    pid = os.fork()
    if pid == 0:
        try:
            child(path, writing, last_byte)
        finally:
            os._exit(0)
    os.close(writing)
    if not by_byte:
        time.sleep(random_.uniform(0.0, 0.02))
        os.kill(pid, signal.SIGKILL)
    _, ended = os.waitpid(pid, 0)
    with os.fdopen(reading, "rb") as pipe:
        said = set(pipe.read().decode().split())
    return said, os.WIFSIGNALED(ended)


def survive(path, kills):
    random_ = random.Random(5)
    safe, count = set(), 0
    FaultMemory.opened(path, "car", CODES).save()
    while count < kills:
        if len(safe) == len(CODES.codes):
            FaultMemory.opened(path, "car", CODES).clear()
            safe = set()
        said, was_killed = killed(path, random_)
        safe |= said
        count += was_killed
        assert confirmed(FaultMemory.opened(path, "car", CODES)) >= safe
    FaultMemory.opened(path, "car", CODES).save()
    assert [each.name for each in path.parent.iterdir()] == [path.name]


def test_killed_at_random_bytes_it_loses_no_confirmed_code(tmp_path):
    survive(tmp_path / "memory.json", 10)


@pytest.mark.slow
def test_killed_a_thousand_times_it_loses_no_confirmed_code(tmp_path):
    survive(tmp_path / "memory.json", 1000)
