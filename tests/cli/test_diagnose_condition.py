"""What 'tierod diagnose --monitor condition' prints, writes and stores for a user."""

import json

import numpy as np
import pytest

from tierod.cli import main
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.monitors.condition.signals import ACTUATORS, ELEMENTS, OF_AUTOMATED
from tierod_lab.papers.condition.drives import LOSS, Drive, Injected
from tierod_lab.papers.condition.recorded import recorded, without


@pytest.fixture(scope="module")
def faulty():
    """The steering angle reads nothing from 15 s to 25 s."""
    injected = Injected("steering_wheel_angle", LOSS, start=15.0, end=25.0)
    return recorded(Drive("long-round", 40.0, 1, 11, (injected,)))


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def diagnose(recording, *arguments):
    write(recording, "drive.parquet")
    return main(["diagnose", "drive.parquet", "--vehicle", "smartload", "--monitor", "condition", *arguments])


def test_every_element_has_a_trouble_code_of_its_own():
    codes = load_trouble_codes().of_monitor("condition")
    assert {name.replace("_", "-") for name in ELEMENTS} < set(codes)
    numbers = sorted(code.code.split("-")[0] for code in codes.values())
    assert numbers == [f"C1A{0x30 + place:X}" for place in range(len(ELEMENTS) + 1)]


def test_a_lost_sensor_is_reported_and_shown_and_ends_with_one(place, faulty, capsys):
    assert diagnose(faulty) == 1
    printed = " ".join(capsys.readouterr().out.split())
    assert "steering wheel angle sensor: total loss from 1" in printed
    assert "C1A33-64" in printed
    page = (place / "drive-condition.html").read_text(encoding="utf-8")
    assert "Sensors and actuators over time" in page
    assert "Steering wheel angle: its reading, and what replaced it" in page


def test_what_replaces_a_sensor_goes_into_a_recording(place, faulty, capsys):
    assert diagnose(faulty, "--no-report", "--signals", "signals.parquet") == 1
    assert "signals: signals.parquet" in capsys.readouterr().out
    result = read("signals.parquet")
    supplied, reading = result["supplied_steering_wheel_angle"], result["steering_wheel_angle"]
    assert supplied.unit == reading.unit == "rad"
    lost = result["state_of_steering_wheel_angle"].values == 1.0
    assert np.count_nonzero(lost & (supplied.time < 25.0)) > 800
    truth = faulty["truth_steering_wheel_angle"].values[: len(lost)]
    assert np.all(reading.values[lost & (supplied.time < 24.9)] == 0.0)
    assert np.std((supplied.values - truth)[lost]) < 0.3 * np.std(truth[lost])
    fault_free = ~lost & (supplied.time > 1.0) & (supplied.time < 14.9)
    np.testing.assert_allclose(supplied.values[fault_free], reading.values[fault_free])


def test_signals_go_over_nothing_that_was_given_and_into_a_known_format(place, faulty, capsys):
    assert diagnose(faulty, "--no-report", "--signals", "drive.parquet") == 3
    assert "--signals" in capsys.readouterr().err
    assert diagnose(faulty, "--no-report", "--signals", "signals.txt") == 3
    assert "no ending that can be written" in capsys.readouterr().err


def test_the_document_holds_state_episode_substitute_and_code(place, faulty, capsys):
    assert diagnose(faulty, "--no-report", "--json") == 1
    document = json.loads(capsys.readouterr().out)
    (element,) = [each for each in document["elements"] if each["status"] == "fault"]
    assert (element["name"], element["trouble_code"]) == ("steering_wheel_angle", "C1A33-64")
    assert element["episodes"][0]["kind"] == "total loss"
    assert element["substitute"].startswith("filter of the others")
    assert [each["name"] for each in document["elements"]] == [*OF_AUTOMATED, *ACTUATORS]


def test_the_fault_memory_takes_the_code_and_gives_it_back(place, faulty, capsys):
    assert diagnose(faulty, "--no-report", "--memory", "memory.json") == 1
    capsys.readouterr()
    assert main(["faults", "read", "memory.json", "--json"]) == 0
    stored = json.loads(capsys.readouterr().out)["codes"]
    assert [each["code"] for each in stored] == ["C1A33-64"]
    assert main(["faults", "read", "memory.json"]) == 0
    assert "C1A33-64" in capsys.readouterr().out


def test_a_missing_sensor_is_no_error_and_stores_nothing(place, faulty, capsys):
    fault_free = without(recorded(Drive("long-round", 40.0, 1, 11)), "tie_rod_force")
    assert diagnose(fault_free, "--no-report", "--memory", "memory.json") == 0
    assert "the recording has no tie rod force" in " ".join(capsys.readouterr().out.split())
    assert main(["faults", "read", "memory.json", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["codes"] == []
