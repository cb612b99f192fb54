from __future__ import annotations

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


def test_a_file_that_appeared_meanwhile_is_not_overwritten(tmp_path):
    path = tmp_path / "memory.json"
    memory = FaultMemory.opened(path, "car", CODES)
    path.write_text('{"mine": 1}')
    with pytest.raises(OutputError, match="not the one that was read"):
        memory.save()
    assert path.read_text() == '{"mine": 1}'


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
