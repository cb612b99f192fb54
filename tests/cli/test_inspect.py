import json
import os
import shlex
from dataclasses import replace

import numpy as np
import pytest

from shared_data import shared_data
from tierod.cli import main
from tierod.core.graph.kernel import _attempted
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.monitors.registry import MONITORS
from tierod.report.display import without_advice
from tierod.vehicles import load
from tierod_lab.ground import drive


def recording(names, **values):
    time = np.arange(600) / 100.0
    rng = np.random.default_rng(0)
    channels = {name: values.get(name, rng.normal(0.0, 0.1, len(time))) for name in names}
    units = {name: SIGNALS[name].unit if name in SIGNALS else "V" for name in names}
    return Recording({name: Channel(name, time, data, units[name]) for name, data in channels.items()})


@pytest.fixture
def compiled_in_a_moment(monkeypatch):
    """Kernels for signals that no other test has together, run over seconds."""
    monkeypatch.setenv("TIEROD_CFLAGS", "-O0")
    _attempted.cache_clear()
    yield
    _attempted.cache_clear()  # later tests of the same process run faster kernels


@pytest.fixture
def whole(tmp_path):
    path = tmp_path / "drive.parquet"
    write(recording(MONITORS["friction"].required), path)
    return path


def test_says_which_monitor_can_run(whole, capsys):
    assert main(["inspect", str(whole)]) == 0
    printed = capsys.readouterr().out
    assert "friction: can run" in printed
    for name in MONITORS["friction"].required:
        assert name in printed


def test_says_on_what_condition_a_monitor_can_run_and_that_a_variant_must_be_chosen(whole, capsys):
    main(["inspect", str(whole)])
    printed = " ".join(capsys.readouterr().out.split())
    assert "hysteresis: can run with a vehicle file if this is a lock-to-lock test of the standing car" in printed
    assert "choose --variant hoist or ground" in printed


@pytest.mark.usefixtures("compiled_in_a_moment")
def test_says_what_a_monitor_lacks(tmp_path, capsys):
    path = tmp_path / "drive.csv"
    write(recording(("yaw_rate", "vehicle_speed", "battery")), path)
    assert main(["inspect", str(path)]) == 0
    printed = capsys.readouterr().out
    assert "friction: cannot run" in printed
    assert "driver_torque" in printed.partition("friction: cannot run")[2].partition("hysteresis")[0]
    assert "Give a channel map" not in printed


def test_shows_the_same_as_json(whole, capsys):
    assert main(["inspect", str(whole), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "tierod.inspection/2"
    assert {channel["name"] for channel in document["channels"]} == set(MONITORS["friction"].required)
    friction = document["monitors"][0]
    assert {"name": "friction", "can_run": True, "condition": "", "obstacles": []}.items() <= friction.items()
    assert [each["name"] for each in friction["variants"]] == list(MONITORS["friction"].variants)
    lacking = document["monitors"][list(MONITORS).index("motor-angle")]
    assert not lacking["can_run"]
    assert all("motor_current_alpha" in each["obstacle"] for each in lacking["variants"])


def test_lists_channels_without_a_name_only_where_asked(tmp_path, capsys):
    names = ("yaw_rate", *(f"x{index}" for index in range(60)))
    path = tmp_path / "drive.parquet"
    write(recording(names), path)
    main(["inspect", str(path)])
    assert "... and 20 channels without a known name" in capsys.readouterr().out
    main(["inspect", str(path), "--all"])
    assert "x59" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "content"), [("empty.csv", b""), ("half.mf4", b"MDF     4.10"), ("no.blf", b"LOGG\0\0")]
)
def test_a_broken_file_is_one_sentence(tmp_path, capsys, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    assert main(["inspect", str(path)]) == 3
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert name in captured.err


def test_an_absent_file_is_one_sentence(tmp_path, capsys):
    assert main(["inspect", str(tmp_path / "absent.mf4")]) == 3
    assert "check the path" in capsys.readouterr().err


def test_a_can_log_with_the_vehicle_that_knows_its_bus(capsys):
    assert main(["inspect", str(shared_data("rav4_highway_minute", "can.log")), "--vehicle", "rav4"]) == 0
    printed = capsys.readouterr().out
    assert "raw counts, not calibrated" in printed
    assert "friction: can run" in printed


@pytest.fixture
def foreign(tmp_path, monkeypatch):
    """A CSV file with German titles in the working directory."""
    monkeypatch.chdir(tmp_path)
    time = np.arange(1000) / 50.0
    yaw = 0.3 * np.sin(time)
    table = np.column_stack([time, np.degrees(yaw), -8.0 * yaw, 8.0 - 0.75 * yaw, 8.0 + 0.75 * yaw, time])
    header = "Zeit,Gierrate,Querbeschleunigung,Radgeschwindigkeit_HL,Radgeschwindigkeit_HR,Tank,Gierrate_QF"
    path = tmp_path / "fahrt 1.csv"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt=",".join(["%.5f"] * 6 + ["valid"]))
    return path


def test_writes_a_map_and_names_the_next_command(foreign, capsys):
    assert main(["inspect", foreign.name, "--write-map", "car.channels.toml"]) == 0
    printed = capsys.readouterr().out
    assert "Querbeschleunigung" in printed
    assert "1 column was not matched; the map lists it" in printed
    assert "not read, since they hold text: Gierrate_QF" in printed
    assert 'hold text: "Gierrate_QF"' in foreign.with_name("car.channels.toml").read_text()
    assert main(["inspect", foreign.name, "--map", "car.channels.toml"]) == 0
    assert "need an entry in car.channels.toml" in capsys.readouterr().err
    (line,) = [line for line in printed.splitlines() if line.startswith("go on with: tierod ")]
    assert main(shlex.split(line)[4:]) == 0
    car = load("car.toml")
    found = read(foreign, channel_map=car.channel_map)
    assert found["yaw_rate"].unit == "rad/s"
    assert found["lateral_acceleration"].values == pytest.approx(8.0 * found["yaw_rate"].values, abs=1e-3)


def test_a_map_with_a_vehicle_goes_on_with_the_judgement(foreign, capsys):
    assert main(["inspect", foreign.name, "--vehicle", "midsize-eps", "--write-map", "other.toml"]) == 0
    assert f"tierod diagnose '{foreign.name}' --vehicle midsize-eps --map other.toml" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--write-map", "old.toml"], "--overwrite"),
        (["--write-map", "map.txt"], "ends in .toml"),
        (["--write-map", "nowhere/map.toml"], "nowhere"),
        (["--write-map", "map.toml", "--json"], "exclude each other"),
        (["--write-map", "map.toml", "--map", "old.toml"], "exclude each other"),
    ],
)
def test_a_map_that_cannot_be_written_is_refused(foreign, arguments, sentence, tmp_path, capsys):
    (tmp_path / "old.toml").write_text("mine")
    assert main(["inspect", foreign.name, *arguments]) == 3
    assert sentence in capsys.readouterr().err
    assert (tmp_path / "old.toml").read_text() == "mine"


def test_shows_the_names_in_the_file(foreign, capsys):
    assert main(["inspect", foreign.name]) == 0
    assert "Gierrate" in capsys.readouterr().out
    assert main(["inspect", foreign.name, "--json"]) == 0
    sources = {row["name"]: row["source"] for row in json.loads(capsys.readouterr().out)["channels"]}
    assert sources["yaw_rate"] == "Gierrate"


def states(path, capsys, *arguments):
    assert main(["inspect", str(path), "--json", *arguments]) == 0
    return {each["name"]: each for each in json.loads(capsys.readouterr().out)["monitors"]}


def test_condition_needs_enough_sensors_also_where_no_vehicle_is_named(tmp_path, capsys):
    motion = ("yaw_rate", "steering_wheel_angle", "wheel_speed_rear_left", "wheel_speed_rear_right")
    for names, able in ((motion, True), (motion[:2], False)):
        path = tmp_path / f"{len(names)}.parquet"
        write(recording(names, **dict.fromkeys(motion[2:], np.full(600, 10.0))), path)
        found = states(path, capsys)["condition"]
        assert found["can_run"] is able
        assert able or "fewer than" in found["obstacles"][0]


def test_a_motor_that_is_sampled_too_slowly_cannot_be_judged_whether_a_vehicle_is_named_or_not(tmp_path, capsys):
    path = tmp_path / "motor.parquet"
    time = np.arange(2000) / 625.0
    names = MONITORS["motor-angle"].required
    channels = {name: Channel(name, time, np.sin(time), SIGNALS[name].unit) for name in names}
    write(Recording(channels), path)
    for arguments in ((), ("--vehicle", "motor-bench")):
        found = states(path, capsys, *arguments)["motor-angle"]
        code = main(["diagnose", str(path), "--vehicle", "motor-bench", "--no-report"])
        refused = capsys.readouterr().err
        assert found["can_run"] is (code != 3)
        assert found["can_run"] or found["obstacles"][0][:40] in refused


def test_inspection_and_diagnosis_say_the_same_and_what_cannot_run_leaves_the_exit_code(tmp_path, capsys):
    motion = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "steering_wheel_angle")
    whole, car = drive(minutes=1.0, seed=3), str(tmp_path / "car.toml")
    write(replace(whole, channels={name: whole[name] for name in motion}), tmp_path / "slip.parquet")
    assert main(["new", car, "--class", "midsize"]) == 0
    given = [str(tmp_path / "slip.parquet"), "--vehicle", car]
    capsys.readouterr()
    inspected = states(given[0], capsys, *given[1:])
    assert main(["diagnose", *given, "--no-report", "--json"]) == 0
    (judged,) = json.loads(capsys.readouterr().out)["recordings"]
    missed = {each["monitor"]: without_advice(each["reason"]) for each in judged["not_run"]}
    assert judged["diagnoses"].keys() == {name for name, each in inspected.items() if each["can_run"]} == {"sideslip"}
    assert missed == {
        name: without_advice(each["obstacles"][0]) for name, each in inspected.items() if not each["can_run"]
    }
    assert missed["condition"].startswith("fewer than 4 sensors give a reading")
    assert missed["hysteresis"] == "needs driver_torque, motor_torque, which the recording does not have"


@pytest.mark.parametrize("ending", ["parquet", "csv", "mf4", "mat", "mcap"])
def test_a_name_that_is_not_utf_8_is_written_and_read(ending, tmp_path, capsys):
    write(recording(["vehicle_speed"]), tmp_path / "drive.csv")
    path = tmp_path / os.fsdecode(b"M\xfcller." + ending.encode())
    assert main(["convert", str(tmp_path / "drive.csv"), "-o", str(path)]) == 0
    capsys.readouterr()
    assert main(["inspect", str(path), "--json"]) == 0
    said = capsys.readouterr()
    assert [each["name"] for each in json.loads(said.out.encode())["channels"]] == ["vehicle_speed"]
