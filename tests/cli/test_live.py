"""The commands `live`, `replay` and `convert`: what they print, and what they refuse."""

import json

import numpy as np
import pytest

from live_drives import database_file, drive
from tierod.cli import main
from tierod.core.recording import Channel, Recording
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
    assert any("neither sources" in each for each in said["lost"])


def test_convert_refuses_what_it_cannot_write(tmp_path, capsys):
    write(Recording({"a": Channel("a", np.arange(9) / 9.0, np.arange(9.0), "")}), tmp_path / "in.csv")
    refused(capsys, ["convert", tmp_path / "in.csv", "-o", tmp_path / "in.csv"], "would overwrite")
    refused(capsys, ["convert", tmp_path / "in.csv", "-o", tmp_path / "out.bag"], "no ending that can be written")
    refused(capsys, ["convert", tmp_path / "in.csv", "-o", tmp_path / "no" / "out.mat"], "create it first")
    refused(capsys, ["convert", tmp_path / "nothing.mcap", "-o", tmp_path / "out.mat"], "there is no file")
    (tmp_path / "empty").mkdir()
    refused(capsys, ["convert", tmp_path / "empty", "-o", tmp_path / "out.mat"], "a folder without a recording")


def test_live_without_a_frame_could_not_judge(tmp_path, capsys):
    arguments = ["live", *BUS, "--vehicle", "midsize-eps", "--dbc", str(database_file(tmp_path)), "--seconds", "0.3"]
    assert main([*arguments, "--monitor", "friction", "--json"]) == 2


def test_live_refuses_in_one_sentence(tmp_path, capsys):
    car = ["--vehicle", "midsize-eps"]
    refused(capsys, ["live", *BUS, *car], "names no CAN database; give one with --dbc")
    dbc = ["--dbc", database_file(tmp_path)]
    wrong = ["--interface", "socketcam", "--channel", "can0"]
    refused(capsys, ["live", *wrong, *car, *dbc], "no interface 'socketcam'; did you mean 'socketcan'")
    absent = ["--interface", "socketcan", "--channel", "can77"]
    refused(capsys, ["live", *absent, *car, *dbc], "can77 cannot be opened", "check that the device is plugged in")
    refused(capsys, ["live", *BUS, *car, *dbc, "--period", "0"], "--period needs a positive time")
    refused(capsys, ["live", *BUS, *car, *dbc, "--monitor", "frictoin"], "did you mean 'friction'")
    refused(capsys, ["live", *BUS, *car, *dbc, "--log", tmp_path / "no" / "x.mf4"], "there is no folder")
    same = ["--log", tmp_path / "x", "--checkpoint", tmp_path / "x"]
    refused(capsys, ["live", *BUS, *car, *dbc, *same], "would overwrite")


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
    refused(capsys, ["replay", tmp_path / "drive.parquet", *BUS, "--loss", "2"], "--loss is a share between 0 and 1")
    refused(capsys, ["replay", tmp_path / "drive.parquet", *BUS], "has no signal of the databases")
    refused(capsys, ["replay", tmp_path / "none.mf4", *BUS], "there is no file")
