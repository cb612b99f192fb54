import dataclasses
import json

import numpy as np
import pytest

from shared_data import shared_data
from tierod.cli import main
from tierod.cli.inspect import fewest_obstacles, obstacles
from tierod.findings import ChannelQuality
from tierod.monitors.registry import MONITORS
from tierod.monitors.session import Monitor, Variant
from tierod.recording import Channel, Recording
from tierod.signals import SIGNALS
from tierod.writers import write

MONITOR = Monitor("m", "M", "S", "source", ("yaw_rate", "vehicle_speed"), (), 100.0, 20.0, 0.1, {}, None)
GOOD = ChannelQuality("", "", "", 100, 100.0, 0.0, 0.01, -1.0, 1.0)


def named(**qualities):
    return {name: dataclasses.replace(row, name=name) for name, row in qualities.items()}


def test_nothing_stands_against_good_channels():
    assert obstacles(MONITOR, named(yaw_rate=GOOD, vehicle_speed=GOOD)) == []


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"rate": 1.0}, "vehicle_speed comes at 1 Hz; 20 Hz are needed"),
        ({"minimum": 3.0, "maximum": 3.0}, "vehicle_speed is constant at 3"),
        ({"samples": 2, "minimum": 3.0, "maximum": 3.0}, "vehicle_speed has too few samples (2)"),
        ({"missing_share": 1.0}, "vehicle_speed holds no values"),
    ],
)
def test_what_a_channel_lacks_is_named(change, sentence):
    row = dataclasses.replace(GOOD, **change)
    assert obstacles(MONITOR, named(yaw_rate=GOOD, vehicle_speed=row)) == [sentence]
    assert obstacles(MONITOR, named(vehicle_speed=GOOD)) == ["yaw_rate is missing"]


def test_another_variant_may_have_what_the_default_lacks():
    plain = Variant("plain", "", "", lambda *_: None)
    other = Variant("other", "", "", lambda *_: None, required=("yaw_rate", "motor_torque"))
    monitor = dataclasses.replace(MONITOR, variants={"plain": plain, "other": other}, default="plain")
    assert fewest_obstacles(monitor, named(yaw_rate=GOOD, motor_torque=GOOD)) == []
    assert fewest_obstacles(monitor, named(motor_torque=GOOD)) == ["yaw_rate is missing", "vehicle_speed is missing"]


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
    assert main(["inspect", str(whole)]) == 0
    printed = capsys.readouterr().out
    assert "friction: can run" in printed
    for name in MONITORS["friction"].required:
        assert name in printed


def test_says_on_what_condition_a_monitor_can_run_and_that_a_variant_must_be_chosen(whole, capsys):
    main(["inspect", str(whole)])
    printed = " ".join(capsys.readouterr().out.split())
    assert "hysteresis: can run if this is a lock-to-lock test of the standing car" in printed
    assert "choose --variant hoist or ground" in printed


def test_says_what_a_monitor_lacks(tmp_path, capsys):
    path = tmp_path / "drive.csv"
    write(recording(("yaw_rate", "vehicle_speed", "battery")), path)
    assert main(["inspect", str(path)]) == 0
    printed = capsys.readouterr().out
    assert "friction: cannot run" in printed
    assert "- driver_torque is missing" in printed


def test_tells_the_same_as_json(whole, capsys):
    assert main(["inspect", str(whole), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "tierod.inspection/1"
    assert {channel["name"] for channel in document["channels"]} == set(MONITORS["friction"].required)
    assert document["monitors"][0] == {"name": "friction", "can_run": True, "condition": "", "obstacles": []}


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
