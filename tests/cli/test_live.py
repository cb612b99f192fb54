"""The commands `live`, `replay` and `convert`: what they print, and what they refuse."""

import json

import pytest

from live_drives import database_file, drive
from tierod.cli import main
from tierod.io.writers import write

pytest.importorskip("can")
pytest.importorskip("cantools")

BUS = ["--interface", "virtual", "--channel", "cli"]


def refused(capsys, arguments, *words):
    assert main([str(each) for each in arguments]) == 3
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    for word in words:
        assert word in err


def test_convert_says_what_the_format_cannot_hold(tmp_path, capsys):
    write(drive(1.0), tmp_path / "in.parquet")
    assert main(["convert", str(tmp_path / "in.parquet"), "-o", str(tmp_path / "out.mat"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["channels"] == 7
    assert any("but no sources" in each for each in said["lost"])


def test_options_of_interfaces():
    from tierod.core.errors import ParameterError
    from tierod.live.buses import interface_options

    given = ["data_bitrate=2000000", "2:app_name=CAN=alyzer", "1:port=0x10", "fast=true", "timeout=0.5"]
    assert interface_options(given, 2) == [
        {"data_bitrate": 2000000, "port": 16, "fast": True, "timeout": 0.5},
        {"data_bitrate": 2000000, "app_name": "CAN=alyzer", "fast": True, "timeout": 0.5},
    ]
    for wrong, sentence in (("x", "NAME=VALUE"), ("3:a=1", "buses 1 to 2"), ("0:a=1", "1 to 2"), ("fd=1", "by --fd")):
        with pytest.raises(ParameterError, match=sentence):
            interface_options([wrong], 2)


def test_replay_says_that_two_buses_become_one(tmp_path, capsys):
    lines = [f"({1_700_000_000 + place / 100:.6f}) can{place % 2} 100#0000" for place in range(40)]
    (tmp_path / "two.log").write_text("\n".join(lines) + "\n")
    arguments = ["replay", str(tmp_path / "two.log"), *BUS, "--speed", "0"]
    assert main(arguments) == 0
    assert "frames of bus 2 of the recording go to bus 1 too" in capsys.readouterr().err
    assert main([*arguments, "--channel", "cli2"]) == 0
    assert "go to bus" not in capsys.readouterr().err


def test_replay_onto_a_virtual_bus(tmp_path, capsys):
    write(drive(1.0), tmp_path / "drive.parquet")
    dbc = ["--dbc", str(database_file(tmp_path))]
    arguments = ["replay", str(tmp_path / "drive.parquet"), *BUS, *dbc, "--speed", "0", "--loss", "0.5", "--seed", "3"]
    assert main([*arguments, "--json"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert first["sent"] + first["lost"] == 200
    assert main([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == first


def test_replay_refuses_in_one_sentence(tmp_path, capsys):
    write(drive(1.0), tmp_path / "drive.parquet")
    dbc = ["--dbc", database_file(tmp_path), "--speed", "0"]
    (tmp_path / "bare.csv").write_text("time,yaw_rate\n" + "".join(f"{k / 100},{k}\n" for k in range(50)))
    refused(
        capsys, ["replay", tmp_path / "bare.csv", *BUS, *dbc], "'yaw_rate' has no unit, and ESP.yaw_rate is sent in"
    )
    (tmp_path / "gaps.csv").write_text(
        "time,yaw_rate [rad/s],vehicle_speed [m/s]\n" + "".join(f"{k / 100},{k if k % 2 else ''},\n" for k in range(50))
    )
    refused(
        capsys,
        ["replay", tmp_path / "gaps.csv", *BUS, *dbc],
        "50 frames were not sent, since ESP.vehicle_speed is missing there",
    )
