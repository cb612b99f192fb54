"""What 'tierod diagnose' prints, writes and ends with."""

import dataclasses
import json

import numpy as np
import pytest

import tierod
from driven import drive
from tierod.cli import main
from tierod.core.recording import Channel, Recording
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.monitors.condition.signals import ACTUATORS, OF_AUTOMATED
from tierod_lab.papers.condition.drives import LOSS, Drive, Injected
from tierod_lab.papers.condition.recorded import recorded


@pytest.fixture(scope="module")
def healthy() -> Recording:
    return drive(minutes=4.0, seed=3)


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def diagnose(*arguments: object) -> int:
    return main(["diagnose", *map(str, arguments)])


def test_a_healthy_drive_ends_with_zero_and_a_report_beside_the_user(place, healthy, capsys):
    write(healthy, "drive.parquet")
    assert diagnose("drive.parquet", "--vehicle", "midsize-eps") == 0
    captured = capsys.readouterr()
    assert "HEALTHY" in captured.out
    assert "report: drive-friction.html" in captured.out
    assert (place / "drive-friction.html").read_text(encoding="utf-8").startswith("<!doctype html>")


def test_raw_counts_cannot_be_judged_and_end_with_two(place, healthy, capsys):
    raw = [dataclasses.replace(healthy[name], unit="count") for name in ("driver_torque", "motor_torque")]
    write(healthy.with_channels(raw), "drive.parquet")
    assert diagnose("drive.parquet", "--vehicle", "rav4", "--no-report") == 2
    assert "counts" in capsys.readouterr().out


def test_the_vehicle_that_a_recording_names_is_taken_and_reported(place, healthy, capsys):
    write(Recording(healthy.channels, {"virtual_car": "midsize-eps"}), "drive.parquet")
    assert diagnose("drive.parquet", "--no-report") == 0
    assert "vehicle: midsize-eps, named by the recording" in capsys.readouterr().err


def test_a_report_is_never_written_over_what_was_given(place, healthy, capsys):
    write(healthy, "drive.parquet")
    before = (place / "drive.parquet").read_bytes()
    assert diagnose("drive.parquet", "--vehicle", "midsize-eps", "--output", place / "drive.parquet") == 3
    assert "would overwrite drive.parquet" in capsys.readouterr().err
    assert (place / "drive.parquet").read_bytes() == before
    new = ("--memory", "memory.json", "--output", "memory.json")
    assert diagnose("drive.parquet", "--vehicle", "midsize-eps", *new) == 3
    assert not (place / "memory.json").exists()


def test_names_with_brackets_and_tags_are_text(place, healthy, capsys):
    evil = "<script>alert(1)</script>"
    channel = dataclasses.replace(healthy["yaw_rate"], source=f"{evil}[/bold]")
    write(Recording({**healthy.channels, "yaw_rate": channel}, {"comment": evil}), "[bold]drive.parquet")
    main(["vehicles", "midsize-eps", "--toml"])
    text = capsys.readouterr().out
    line = next(line for line in text.splitlines() if line.startswith("description"))
    (place / "car.toml").write_text(text.replace(line, f'description = "{evil}[/bold]"'), encoding="utf-8")
    assert main(["vehicles", "car.toml"]) == 0
    assert f"{evil}[/bold]" in capsys.readouterr().out
    assert diagnose("[bold]drive.parquet", "--vehicle", "car.toml", "--output", "[bold].html") == 0
    assert "report: [bold].html" in capsys.readouterr().out
    page = (place / "[bold].html").read_text(encoding="utf-8")
    assert evil not in page
    assert page.count("&lt;script&gt;alert(1)") >= 3


def test_numbers_beyond_any_physical_range_are_missing_and_counted(place, capsys):
    time = np.arange(3000) / 100.0
    units = {"yaw_rate": "rad/s", "steering_wheel_angle": "rad", "vehicle_speed": "m/s"}
    units["lateral_acceleration"] = "m/s**2"
    channels = {}
    for name, unit in units.items():
        values = np.sin(time) * (15.0 if name == "lateral_acceleration" else 1.0) + 15.0 * (name == "vehicle_speed")
        values[1500:1505], values[1505:1510] = 1e300, -3.4e38
        channels[name] = Channel(name, time, values, unit)
    recording = Recording(channels)
    write(recording, "big.parquet")
    words = ("--vehicle", "midsize-eps", "--monitor", "sideslip", "--no-report", "--json")
    assert diagnose("big.parquet", *words) in (0, 1, 2)
    captured = capsys.readouterr()
    assert "Warning" not in captured.err
    assert ".py" not in captured.err
    said = "10 values beyond any physical range taken as missing"
    quality = {each["name"]: each["remarks"] for each in json.loads(captured.out)["quality"]}
    for name in units:
        assert said in quality[name]
    found = tierod.diagnose(recording, vehicle="midsize-eps", monitor="sideslip")
    assert all(said in row.remarks for row in found.quality if row.name in units)


@pytest.fixture(scope="module")
def lost_angle():
    """The steering angle reads nothing from 15 s to 25 s."""
    injected = Injected("steering_wheel_angle", LOSS, start=15.0, end=25.0)
    return recorded(Drive("long-round", 40.0, 1, 11, (injected,)))


def condition(recording, *arguments):
    write(recording, "drive.parquet")
    return main(["diagnose", "drive.parquet", "--vehicle", "smartload", "--monitor", "condition", *arguments])


def test_a_lost_sensor_is_reported_and_shown_and_ends_with_one(place, lost_angle, capsys):
    assert condition(lost_angle, "--no-report") == 1
    answer = capsys.readouterr().out
    assert len(answer.splitlines()) <= 10
    assert "change      at 15 s, ended at 25 s" in answer
    assert condition(lost_angle, "--details") == 1
    printed = " ".join(capsys.readouterr().out.split())
    assert "steering wheel angle sensor: total loss from 1" in printed
    assert "C1A33-64" in printed
    page = (place / "drive-condition.html").read_text(encoding="utf-8")
    assert "Sensors and actuators over time" in page
    assert "Steering wheel angle: its reading, and what replaced it" in page


def test_what_replaces_a_sensor_goes_into_a_recording(place, lost_angle, capsys):
    assert condition(lost_angle, "--no-report", "--signals", "signals.parquet") == 1
    assert "signals: signals.parquet" in capsys.readouterr().out
    result = read("signals.parquet")
    supplied, reading = result["supplied_steering_wheel_angle"], result["steering_wheel_angle"]
    assert supplied.unit == reading.unit == "rad"
    lost = result["state_of_steering_wheel_angle"].values == 1.0
    assert np.count_nonzero(lost & (supplied.time < 25.0)) > 800
    truth = lost_angle["truth_steering_wheel_angle"].values[: len(lost)]
    assert np.all(reading.values[lost & (supplied.time < 24.9)] == 0.0)
    assert np.std((supplied.values - truth)[lost]) < 0.3 * np.std(truth[lost])
    fault_free = ~lost & (supplied.time > 1.0) & (supplied.time < 14.9)
    np.testing.assert_allclose(supplied.values[fault_free], reading.values[fault_free])


def test_the_document_holds_state_episode_substitute_and_code(place, lost_angle, capsys):
    assert condition(lost_angle, "--no-report", "--json") == 1
    document = json.loads(capsys.readouterr().out)
    (element,) = [each for each in document["elements"] if each["status"] == "fault"]
    assert (element["name"], element["trouble_code"]) == ("steering_wheel_angle", "C1A33-64")
    assert element["episodes"][0]["kind"] == "total loss"
    assert element["substitute"].startswith("filter of the others")
    assert [each["name"] for each in document["elements"]] == [*OF_AUTOMATED, *ACTUATORS]
