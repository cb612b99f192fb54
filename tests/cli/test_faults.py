import json

import numpy as np
import pytest

from diagnosis.memories import drive
from tierod.cli import main
from tierod.core.findings import Diagnosis, Finding, Status
from tierod.core.recording import Aligned
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.monitors.memory import MemoryFeed
from tierod.monitors.session import StatusChange
from tierod_lab.ground.faults import BEHAVIOURS, load, shipped


def test_lists_what_is_shipped_with_a_sentence_each(capsys):
    assert main(["faults"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    for name in shipped():
        assert name in printed
    assert "The yaw rate sensor reads zero for 20 s." in printed


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("friction-step", "step: to 12.5 N*m Begins at 30 s, lasts until the end."),
        ("yaw-rate-offset", "offset: size 0.3 rad/s Begins at 20 s, lasts 20 s."),
        ("yaw-rate-outlier", "outlier: factor 3 Begins at 20 s, lasts 1 s."),
        ("driver-torque-drift", "drift: rate 0.00333333 N*m/s, limit 1 N*m"),
        ("friction-intermittent", "intermittent: (step: to 12.5 N*m), mean on 5 s, mean off 20 s"),
        ("vehicle-speed-stuck", "Begins when vehicle_speed > 50 km/h for 1 s"),
        ("heavy-load", "Begins from the beginning"),
    ],
)
def test_words(name, words, capsys):
    main(["faults", name])
    assert words in " ".join(capsys.readouterr().out.split())


def test_prints_a_file_to_begin_with(capsys, tmp_path):
    assert main(["faults", "tyre-pressure-low", "--toml"]) == 0
    mine = tmp_path / "tyre-pressure-low.toml"
    mine.write_text(capsys.readouterr().out, encoding="utf-8")
    assert load(mine).fault == load("tyre-pressure-low").fault
    assert main(["faults", str(mine)]) == 0
    assert "use =" in capsys.readouterr().out


def test_lists_how_elements_can_behave(capsys):
    assert main(["faults", "--behaviours"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in BEHAVIOURS)
    assert main(["faults", "--behaviours", "--json"]) == 0
    drift = next(each for each in json.loads(capsys.readouterr().out)["behaviours"] if each["name"] == "drift")
    assert drift["fields"] == "rate [unit of the element/s], (limit [unit of the element])"


@pytest.fixture
def memory_path(tmp_path):
    memory_path = tmp_path / "memory.json"
    memory = FaultMemory.opened(memory_path, "midsize-eps")
    for _ in range(2):
        drive(memory, {"friction-fault": (-1.0, 5.0, 1.0)})
    return memory_path


def test_read_shows_what_is_stored_and_what_it_asks_for(memory_path, capsys):
    assert main(["faults", "read", str(memory_path)]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "C1A01-92" in printed
    assert "Fault memory of midsize-eps, 2 operation cycles" in printed
    assert "Warning lamp on; reaction: degrade." in printed


def test_read_gives_a_document_and_the_answer_of_an_ecu(memory_path, capsys):
    assert main(["faults", "read", str(memory_path), "--json"]) == 0
    (stored,) = json.loads(capsys.readouterr().out)["codes"]
    assert (stored["code"], stored["byte"], stored["occurrences"]) == ("C1A01-92", "AF", 2)
    assert "confirmed" in stored["status"]
    assert main(["faults", "read", str(memory_path), "friction-fault"]) == 0
    assert json.loads(capsys.readouterr().out) == stored
    assert main(["faults", "snapshot", str(memory_path), "friction-fault", "--json"]) == 0
    frames = json.loads(capsys.readouterr().out)
    assert [frames[each]["cycle"] for each in ("first", "last")] == [1, 2]
    assert frames["last"]["values"]["vehicle_speed"]
    assert main(["faults", "read", str(memory_path), "--uds", "190208"]) == 0
    assert capsys.readouterr().out.strip() == "59 02 FF 5A 01 92 AF"


def test_clear_forgets_and_keeps_a_copy(memory_path, capsys):
    before = memory_path.read_bytes()
    assert main(["faults", "clear", str(memory_path)]) == 0
    assert main(["faults", "read", str(memory_path)]) == 0
    captured = capsys.readouterr()
    assert "No trouble codes." in captured.out
    (kept,) = [each for each in memory_path.parent.iterdir() if each != memory_path]
    assert kept.read_bytes() == before
    assert kept.name in captured.err.replace("\n", "")


def test_a_damaged_memory_is_refused_and_can_be_cleared(memory_path, capsys):
    memory_path.write_bytes(memory_path.read_bytes()[:500])
    assert main(["faults", "read", str(memory_path)]) == 3
    assert "damaged" in capsys.readouterr().err
    assert memory_path.exists()
    assert main(["faults", "clear", str(memory_path), "friction-fault"]) == 3
    assert main(["faults", "clear", str(memory_path)]) == 0
    assert not memory_path.exists()
    assert len(list(memory_path.parent.iterdir())) == 1


@pytest.mark.parametrize("content", ["name = 'car'\nsteering_ratio = 16.0\n", '{"speed": 3}', ""])
@pytest.mark.parametrize("verb", [["read"], ["clear"], ["snapshot", "friction-fault"]])
def test_a_file_that_is_no_memory_is_left_alone(tmp_path, verb, content, capsys):
    memory_path = tmp_path / "car.toml"
    memory_path.write_text(content)
    assert main(["faults", verb[0], str(memory_path), *verb[1:]]) == 3
    said = " ".join(capsys.readouterr().err.split())
    assert "is no fault memory" in said
    assert "clear" not in said
    assert [each.read_text() for each in tmp_path.iterdir()] == [content]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["snapshot", "PATH"], "name a trouble code"),
        (["snapshot", "PATH", "C1A99-00"], "there is no trouble code"),
        (["snapshot", "PATH", "friction-rising"], "has not failed"),
        (["read", "PATH", "--uds", "19x"], "pairs of hexadecimal"),
        (["read", "PATH", "--uds", "14FFFFFF"], "tierod faults clear"),
        (["clear", "PATH", "--uds", "1902FF"], "--uds works with 'read'"),
        (["read", "PATH", "--toml"], "no meaning"),
        (["read", "PATH", "--uds", "1902FF", "--json"], "leave the rest out"),
        (["yaw-rate-offset", "PATH"], "one of read, clear, snapshot, not"),
    ],
)
def test_bad_use_of_a_memory_is_reported_in_a_line(memory_path, arguments, says, capsys):
    before = memory_path.read_bytes()
    assert main(["faults", *[str(memory_path) if each == "PATH" else each for each in arguments]]) == 3
    error = capsys.readouterr().err
    assert says in error
    assert "Traceback" not in error
    assert memory_path.read_bytes() == before


def test_the_course_of_a_verdict_becomes_results_and_the_verdict_the_last_one(tmp_path):
    memory_path = tmp_path / "memory.json"
    feed = MemoryFeed(memory_path, "midsize-eps", "friction")
    time = np.arange(6000) / 100.0
    for piece in np.array_split(np.arange(6000), 7):
        speed = np.column_stack([time[piece], np.zeros(len(piece))])
        feed.add(Aligned(time[piece], speed, ("vehicle_speed", "other")), 100.0)
    course = [StatusChange(10.0, Status.HEALTHY), StatusChange(40.0, Status.RISING), StatusChange(50.0, Status.FAULT)]
    feed.finish(Diagnosis((Finding("friction", Status.FAULT, ""),), created="2026-01-01"), course)
    memory = FaultMemory.opened(memory_path, "midsize-eps")
    assert {name: e.occurrences for name, e in memory.entries.items() if e.occurrences} == {
        "friction-fault": 1,
        "friction-rising": 1,
    }
    frame = memory.entries["friction-fault"].first
    assert frame.instant == pytest.approx(50.0)
    assert frame.at_instant() == {"vehicle_speed": pytest.approx(50.0)}
