import json
import os
import shlex
from dataclasses import replace

import numpy as np
import pytest

from shared_data import shared_data
from tierod.cli import main
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
def whole(tmp_path):
    path = tmp_path / "drive.parquet"
    write(recording(MONITORS["friction"].required), path)
    return path


def test_says_which_monitor_can_run(whole, capsys):
    assert main(["inspect", str(whole), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert main(["inspect", str(whole)]) == 0
    assert "friction: can run" in capsys.readouterr().out
    assert document["schema"] == "tierod.inspection/2"
    assert {channel["name"] for channel in document["channels"]} == set(MONITORS["friction"].required)
    friction = document["monitors"][0]
    assert {"name": "friction", "can_run": True, "condition": "", "obstacles": []}.items() <= friction.items()
    assert [each["name"] for each in friction["variants"]] == list(MONITORS["friction"].variants)
    lacking = document["monitors"][list(MONITORS).index("motor-angle")]
    assert not lacking["can_run"]
    assert all("motor_current_alpha" in each["obstacle"] for each in lacking["variants"])


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


def states(path, capsys, *arguments):
    assert main(["inspect", str(path), "--json", *arguments]) == 0
    return {each["name"]: each for each in json.loads(capsys.readouterr().out)["monitors"]}


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


@pytest.mark.parametrize("ending", ["parquet", "mf4", "mcap"])
def test_a_name_that_is_not_utf_8_is_written_and_read(ending, tmp_path, capsys):
    write(recording(["vehicle_speed"]), tmp_path / "drive.csv")
    path = tmp_path / os.fsdecode(b"M\xfcller." + ending.encode())
    assert main(["convert", str(tmp_path / "drive.csv"), "-o", str(path)]) == 0
    capsys.readouterr()
    assert main(["inspect", str(path), "--json"]) == 0
    said = capsys.readouterr()
    assert [each["name"] for each in json.loads(said.out.encode())["channels"]] == ["vehicle_speed"]


@pytest.mark.parametrize("name", MONITORS)
def test_shows_signals_variants_and_sources(name, capsys):
    assert main(["monitors", name]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    monitor = MONITORS[name]
    for text in (monitor.title, monitor.summary, *monitor.required, *monitor.variants):
        assert text in printed


def test_says_which_parameters_and_signals_a_vehicle_lacks(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "car.channels.toml").write_text('[signals.yaw_rate]\nsource = "yaw"\n')
    assert main(["new", "car.toml", "--class", "midsize"]) == 0
    capsys.readouterr()
    assert main(["monitors", "motor-angle", "--vehicle", "car.toml"]) == 0
    printed = capsys.readouterr().out
    assert "motor-angle: cannot run with car" in printed
    assert "motor_flux" in printed
    assert "motor_current_alpha" in printed
    assert main(["monitors", "motor-angle", "--vehicle", "motor-bench", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["monitors"].values()
    assert found["stator-frame"]["needed"] == []
    assert found["stator-frame"]["needed_signals"] is None


def test_ranks_the_guesses_of_a_vehicle_file_and_lists_no_default_of_another_kind_of_car(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "car.toml", "--class", "midsize"]) == 0
    capsys.readouterr()
    assert main(["monitors", "sideslip", "--vehicle", "car.toml"]) == 0
    printed = capsys.readouterr().out
    assert "steering_ratio" in printed
    assert "known to ±8%" in printed
    assert "'tierod diagnose' ranks the guesses" in printed
    assert main(["monitors", "sideslip", "--vehicle", "car.toml", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["monitors"].values()
    guessed = found["combined"]["guessed"]
    assert guessed.index("front_cornering_stiffness") < guessed.index("rear_distance")
    assert not {"wheelbase", "yaw_rate_noise"} & set(guessed)
    assert "power_assist_factor" not in found["combined"]["optional"]
    assert "yaw_rate_noise" in found["combined"]["optional"]
