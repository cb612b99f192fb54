import json

import numpy as np
import pytest

from diagnosis.memories import drive
from tierod.cli import main
from tierod.core.errors import OutputError
from tierod.core.findings import Diagnosis, Finding, Status
from tierod.core.recording import Aligned
from tierod.diagnosis.entry import CodeStatus
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.monitors.memory import MemoryFeed
from tierod.monitors.session import StatusChange


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "memory.json"
    memory = FaultMemory.opened(path, "midsize-eps")
    for _ in range(2):
        drive(memory, {"friction-fault": (-1.0, 5.0, 1.0)})
    return path


def test_read_shows_what_is_stored_and_what_it_asks_for(path, capsys):
    assert main(["faults", "read", str(path)]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "C1A01-92" in printed
    assert "Fault memory of midsize-eps, 2 operation cycles" in printed
    assert "Warning lamp on; reaction: degrade." in printed


def test_read_gives_a_document_and_the_answer_of_an_ecu(path, capsys):
    assert main(["faults", "read", str(path), "--json"]) == 0
    (stored,) = json.loads(capsys.readouterr().out)["codes"]
    assert (stored["code"], stored["byte"], stored["occurrences"]) == ("C1A01-92", "AF", 2)
    assert "confirmed" in stored["status"]
    assert main(["faults", "read", str(path), "friction-fault"]) == 0
    assert json.loads(capsys.readouterr().out) == stored
    assert main(["faults", "snapshot", str(path), "friction-fault", "--json"]) == 0
    frames = json.loads(capsys.readouterr().out)
    assert [frames[each]["cycle"] for each in ("first", "last")] == [1, 2]
    assert frames["last"]["values"]["vehicle_speed"]
    assert main(["faults", "read", str(path), "--uds", "190208"]) == 0
    assert capsys.readouterr().out.strip() == "59 02 FF 5A 01 92 AF"


def test_a_request_that_suppresses_its_answer_gets_a_word(path, capsys):
    assert main(["faults", "read", str(path), "--uds", "1982FF"]) == 0
    assert "no answer" in capsys.readouterr().out


def test_names_with_brackets_are_text(tmp_path, capsys):
    path = tmp_path / "memory.json"
    drive(FaultMemory.opened(path, "[bold]car[/bold]"), {"friction-fault": 1.0}, date="[red]today")
    assert main(["faults", "read", str(path)]) == 0
    assert main(["faults", "snapshot", str(path), "friction-fault"]) == 0
    printed = capsys.readouterr().out
    assert "of [bold]car[/bold]," in printed
    assert "begun [red]today" in printed


def test_snapshot_shows_the_signals_around_the_failure(path, capsys):
    assert main(["faults", "snapshot", str(path), "C1A01-92"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "5.00 s into operation cycle 2" in printed
    assert "vehicle_speed 54 km/h" in printed


def test_clear_forgets_and_keeps_a_copy(path, capsys):
    before = path.read_bytes()
    assert main(["faults", "clear", str(path)]) == 0
    assert main(["faults", "read", str(path)]) == 0
    captured = capsys.readouterr()
    assert "No trouble codes." in captured.out
    (kept,) = [each for each in path.parent.iterdir() if each != path]
    assert kept.read_bytes() == before
    assert kept.name in captured.err.replace("\n", "")


def test_a_damaged_memory_is_refused_and_can_be_cleared(path, capsys):
    path.write_bytes(path.read_bytes()[:500])
    assert main(["faults", "read", str(path)]) == 3
    assert "damaged" in capsys.readouterr().err
    assert path.exists()
    assert main(["faults", "clear", str(path), "friction-fault"]) == 3
    assert main(["faults", "clear", str(path)]) == 0
    assert not path.exists()
    assert len(list(path.parent.iterdir())) == 1


@pytest.mark.parametrize("content", ["name = 'car'\nsteering_ratio = 16.0\n", "time,v\n0,1\n", '{"speed": 3}', ""])
@pytest.mark.parametrize("verb", [["read"], ["clear"], ["clear", "friction-fault"], ["snapshot", "friction-fault"]])
def test_a_file_that_is_no_memory_is_left_alone(tmp_path, verb, content, capsys):
    path = tmp_path / "car.toml"
    path.write_text(content)
    assert main(["faults", verb[0], str(path), *verb[1:]]) == 3
    said = " ".join(capsys.readouterr().err.split())
    assert "is no fault memory" in said
    assert "clear" not in said
    assert [each.read_text() for each in tmp_path.iterdir()] == [content]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["read"], "needs the file"),
        (["read", "absent.json"], "there is no fault memory absent.json"),
        (["clear", "absent.json"], "nothing to clear"),
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
def test_bad_use_is_reported_in_a_line(path, arguments, says, capsys):
    before = path.read_bytes()
    assert main(["faults", *[str(path) if each == "PATH" else each for each in arguments]]) == 3
    error = capsys.readouterr().err
    assert says in error
    assert "Traceback" not in error
    assert path.read_bytes() == before


def test_the_course_of_a_verdict_becomes_results_and_the_verdict_the_last_one(tmp_path):
    path = tmp_path / "memory.json"
    feed = MemoryFeed(path, "midsize-eps", "friction")
    time = np.arange(6000) / 100.0
    for piece in np.array_split(np.arange(6000), 7):
        speed = np.column_stack([time[piece], np.zeros(len(piece))])
        feed.add(Aligned(time[piece], speed, ("vehicle_speed", "other")), 100.0)
    course = [StatusChange(10.0, Status.HEALTHY), StatusChange(40.0, Status.RISING), StatusChange(50.0, Status.FAULT)]
    feed.finish(Diagnosis((Finding("friction", Status.FAULT, ""),), created="2026-01-01"), course)
    memory = FaultMemory.opened(path, "midsize-eps")
    assert {name: e.occurrences for name, e in memory.entries.items() if e.occurrences} == {
        "friction-fault": 1,
        "friction-rising": 1,
    }
    frame = memory.entries["friction-fault"].first
    assert frame.instant == pytest.approx(50.0)
    assert frame.at_instant() == {"vehicle_speed": pytest.approx(50.0)}


def test_a_verdict_with_a_longer_name_than_those_before_it_counts(tmp_path):
    feed = MemoryFeed(tmp_path / "memory.json", "midsize-eps", "friction")
    time = np.arange(100) / 10.0
    feed.add(Aligned(time, time[:, None], ("vehicle_speed",)), 10.0)
    diagnosis = Diagnosis((Finding("friction", Status.HEALTHY, ""),), created="2026-01-01")
    feed.finish(diagnosis, [StatusChange(-1.0, Status.FAULT)])
    memory = FaultMemory.opened(tmp_path / "memory.json")
    assert not memory.entries["friction-fault"].status & CodeStatus.TEST_FAILED


def test_a_code_with_a_course_of_its_own_ends_as_that_course_does(tmp_path):
    feed = MemoryFeed(tmp_path / "memory.json", "midsize-eps", "friction")
    time = np.arange(600) / 10.0
    feed.add(Aligned(time, time[:, None], ("vehicle_speed",)), 10.0)
    own = [StatusChange(0.0, Status.HEALTHY), StatusChange(20.0, Status.FAULT), StatusChange(59.85, Status.HEALTHY)]
    diagnosis = Diagnosis((Finding("friction", Status.FAULT, ""),), created="2026-01-01")
    _, results, _ = feed.collected(diagnosis, [], {"friction-fault": own})
    assert results["friction-fault"][[100, 300, -2, -1]].tolist() == [-1.0, 1.0, 1.0, -1.0]
    assert not results["friction-rising"].any()


def test_recordings_that_are_judged_side_by_side_are_all_kept(tmp_path):
    feeds = [MemoryFeed(tmp_path / "memory.json", "midsize-eps", "friction") for _ in range(2)]
    time = np.arange(100) / 10.0
    for feed in feeds:
        feed.add(Aligned(time, time[:, None], ("vehicle_speed",)), 10.0)
        feed.finish(Diagnosis((Finding("friction", Status.FAULT, ""),), created="2026-01-01"), ())
    memory = FaultMemory.opened(tmp_path / "memory.json")
    assert memory.cycles == 2
    assert memory.entries["friction-fault"].status & CodeStatus.CONFIRMED


def test_a_missing_folder_is_reported_before_the_recording_is_judged(tmp_path):
    with pytest.raises(OutputError, match="create the folder first"):
        MemoryFeed(tmp_path / "absent" / "memory.json", "midsize-eps", "friction")


def test_a_monitor_without_a_running_verdict_shows_its_verdict_at_the_end(tmp_path):
    feed = MemoryFeed(tmp_path / "memory.json", "midsize-eps", "hysteresis")
    time = np.arange(100) / 10.0
    feed.add(Aligned(time, time[:, None], ("vehicle_speed",)), 10.0)
    feed.finish(Diagnosis((Finding("hysteresis", Status.FAULT, ""),), created="2026-01-01"), ())
    memory = FaultMemory.opened(tmp_path / "memory.json")
    assert memory.entries["friction-lock-to-lock"].first.instant == pytest.approx(9.9)
