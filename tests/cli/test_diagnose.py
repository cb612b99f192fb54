"""What 'tierod diagnose' prints, writes and ends with."""

import dataclasses
import json

import numpy as np
import pytest

import tierod
from driven import drive
from tierod.cli import main
from tierod.core.recording import Channel, Recording
from tierod.io.writers import write
from tierod_lab.ground import FrictionCourse


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


def test_a_fault_ends_with_one(place, capsys):
    write(drive(minutes=6.0, friction=FrictionCourse.step(4.0, 10.0, at=180.0), seed=1), "drive.parquet")
    assert diagnose("drive.parquet", "--vehicle", "midsize-eps", "--no-report", "--json") == 1
    document = json.loads(capsys.readouterr().out)
    assert (document["status"], document["exit_code"]) == ("fault", 1)


def test_without_spread_it_says_that_parameters_count_as_exact(place, healthy, capsys):
    write(healthy, "drive.parquet")
    assert diagnose("drive.parquet", "--vehicle", "midsize-eps", "--no-report", "--json", "--no-spread") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["remarks"]["parameters"].startswith("all parameters of the vehicle are assumed to be exact")


def test_raw_counts_cannot_be_judged_and_end_with_two(place, healthy, capsys):
    raw = [dataclasses.replace(healthy[name], unit="count") for name in ("driver_torque", "motor_torque")]
    write(healthy.with_channels(raw), "drive.parquet")
    assert diagnose("drive.parquet", "--vehicle", "rav4", "--no-report") == 2
    assert "counts" in capsys.readouterr().out


def test_a_recording_that_names_no_vehicle_needs_one(place, healthy, capsys):
    write(Recording(healthy.channels), "drive.parquet")
    assert diagnose("drive.parquet", "--no-report") == 3
    assert "no vehicle is given, and the recording names none" in capsys.readouterr().err


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


def test_a_memory_takes_nothing_where_the_report_cannot_be_written(place, healthy, capsys):
    write(healthy, "drive.parquet")
    new = ("--memory", "memory.json", "--output", "absent/page.html")
    assert diagnose("drive.parquet", "--vehicle", "midsize-eps", *new) == 3
    assert "create the folder first" in capsys.readouterr().err
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


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["absent.parquet", "--vehicle", "midsize-eps"], "there is no file absent.parquet"),
        (["car.toml", "--vehicle", "midsize"], "did you mean 'midsize-eps'"),
        (["drive.parquet"], "there is no file drive.parquet"),
        (["x.csv", "--vehicle", "midsize-eps", "--monitor", "hysteresis"], "choose with --variant"),
    ],
)
def test_what_was_given_wrongly_ends_with_three_in_one_line(place, capsys, arguments, sentence):
    assert diagnose(*arguments) == 3
    captured = capsys.readouterr()
    assert captured.out == ""
    assert len(captured.err.splitlines()) == 1
    assert sentence in captured.err


@pytest.mark.parametrize("number", [1e300, -3.4e38])
def test_numbers_beyond_any_physical_range_are_missing_and_counted(place, capsys, number):
    time = np.arange(3000) / 100.0
    units = {
        "yaw_rate": "rad/s",
        "lateral_acceleration": "m/s**2",
        "steering_wheel_angle": "rad",
        "vehicle_speed": "m/s",
    }
    channels = {}
    for name, unit in units.items():
        values = np.sin(time) * (15.0 if name == "lateral_acceleration" else 1.0) + 15.0 * (name == "vehicle_speed")
        values[1500:1510] = number
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
