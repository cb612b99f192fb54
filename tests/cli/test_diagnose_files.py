"""What 'tierod diagnose' says of the files that it keeps: the baseline and the fault memory."""

import json

import pytest

from driven import drive
from tierod.cli import main
from tierod.core.recording import Recording
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.io.writers import write
from tierod.monitors.baseline import Baseline, load_baseline, store_baseline
from tierod.monitors.run import Run


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Drives by what they are."""
    folder = tmp_path_factory.mktemp("recordings")
    drives = {"healthy": drive(minutes=4.0, seed=3), "faulty": drive(minutes=4.0, friction=12.0, seed=2)}
    drives["short"] = Recording(drives["healthy"].channels).slice(0.0, 60.0)
    for name, recording in drives.items():
        write(recording, folder / f"{name}.parquet")
    write(Recording(drives["healthy"].channels), folder / "again.csv")
    return folder


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def diagnose(recording, *arguments):
    return main(["diagnose", str(recording), "--vehicle", "midsize-eps", "--no-report", "--no-spread", *arguments])


def test_a_remark_says_whether_a_baseline_was_written_or_used(recordings, place, capsys):
    assert diagnose(recordings / "healthy.parquet", "--baseline", "car.json") == 0
    assert "baseline: written to car.json; later recordings are judged against it" in capsys.readouterr().out
    learnt = load_baseline("car.json").learnt
    assert diagnose(recordings / "faulty.parquet", "--baseline", "car.json") == 1
    assert f"baseline: judged against car.json, learnt {learnt}; the file stays as it is" in capsys.readouterr().out


def test_in_json_it_is_a_remark_and_on_the_side_a_line(recordings, place, capsys):
    assert diagnose(recordings / "healthy.parquet", "--baseline", "car.json", "--memory", "m.json", "--json") == 0
    captured = capsys.readouterr()
    remarks = json.loads(captured.out)["remarks"]
    assert remarks["baseline"].startswith("written to car.json")
    assert remarks["fault memory"] == "the recording is operation cycle 1 of the fault memory m.json"
    assert "baseline: written to car.json" in captured.err
    assert "fault memory: the recording is operation cycle 1" in captured.err


@pytest.mark.parametrize(
    ("recording", "arguments", "reason"),
    [
        ("faulty", (), "the verdict is 'fault', and a baseline is learnt from a healthy recording only"),
        ("short", (), "and a baseline is learnt from a healthy recording only"),
        ("healthy", ("--monitor", "sideslip"), "the monitor 'sideslip' learns no baseline"),
    ],
)
def test_a_remark_says_why_a_baseline_was_not_written(recordings, place, capsys, recording, arguments, reason):
    diagnose(recordings / f"{recording}.parquet", "--baseline", "car.json", *arguments)
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("baseline: ")]
    assert line.startswith("baseline: car.json was not written: ")
    assert line.endswith(reason)
    assert not (place / "car.json").exists()


def test_a_baseline_that_appeared_meanwhile_is_left_as_it_is(recordings, place, capsys, monkeypatch):
    other = Baseline("midsize-eps", "friction, pre-sliding", 4.0, 0.1, "N*m", 100.0)

    real = Run.finish

    def judged(*arguments):
        store_baseline(other, "car.json")
        return real(*arguments)

    monkeypatch.setattr(Run, "finish", judged)
    assert diagnose(recordings / "healthy.parquet", "--baseline", "car.json") == 0
    assert "car.json was written by another program in the meantime and is kept" in capsys.readouterr().out
    assert load_baseline("car.json") == other


def memory():
    return FaultMemory.opened("memory.json", "midsize-eps")


@pytest.mark.parametrize(
    ("again", "arguments"),
    [("healthy.parquet", ()), ("again.csv", ()), ("healthy.parquet", ("--variant", "refined"))],
    ids=["the same file", "another file of the same samples", "another variant"],
)
def test_a_recording_that_is_judged_twice_counts_once(recordings, place, capsys, again, arguments):
    assert diagnose(recordings / "healthy.parquet", "--memory", "memory.json") == 0
    assert "fault memory: the recording is operation cycle 1 of the fault memory memory.json" in capsys.readouterr().out
    before = (place / "memory.json").read_bytes()
    assert diagnose(recordings / again, "--memory", "memory.json", *arguments) == 3
    error = capsys.readouterr().err
    assert "already contains this recording, as operation cycle 1 on 20" in error
    assert "nothing was changed. Judge it again without the memory" in error
    assert (place / "memory.json").read_bytes() == before


def test_another_recording_and_another_monitor_are_cycles_of_their_own(recordings, place):
    diagnose(recordings / "healthy.parquet", "--memory", "memory.json")
    diagnose(recordings / "faulty.parquet", "--memory", "memory.json")
    diagnose(recordings / "healthy.parquet", "--memory", "memory.json", "--monitor", "hysteresis", "--variant", "hoist")
    diagnose(recordings / "healthy.parquet", "--memory", "memory.json", "--monitor", "sideslip")
    assert memory().cycles >= 3


def test_a_memory_that_was_cleared_takes_the_recording_again(recordings, place):
    diagnose(recordings / "faulty.parquet", "--memory", "memory.json")
    assert main(["faults", "clear", "memory.json"]) == 0
    assert diagnose(recordings / "faulty.parquet", "--memory", "memory.json") == 1
    assert memory().cycles == 2
