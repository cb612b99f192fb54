import json

import numpy as np
import pytest

from shared_data import shared_data
from tierod.cli import main
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.io.writers import write
from tierod.monitors.registry import MONITORS


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
    assert "hysteresis: can run with a vehicle file if this is a lock-to-lock test of the standing car" in printed
    assert "choose --variant hoist or ground" in printed


def test_says_what_a_monitor_lacks(tmp_path, capsys):
    path = tmp_path / "drive.csv"
    write(recording(("yaw_rate", "vehicle_speed", "battery")), path)
    assert main(["inspect", str(path)]) == 0
    printed = capsys.readouterr().out
    assert "friction: cannot run" in printed
    assert "driver_torque" in printed.partition("friction: cannot run")[2].partition("hysteresis")[0]
    assert "Give a channel map" not in printed


def test_tells_the_same_as_json(whole, capsys):
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
