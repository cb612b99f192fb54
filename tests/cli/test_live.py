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
    assert any("but no sources" in each for each in said["lost"])


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
    refused(capsys, ["live", *absent, *car, *dbc], "can77 cannot be opened")
    refused(capsys, ["live", *BUS, *car, *dbc, "--period", "0"], "--period needs a positive time")
    refused(capsys, ["live", *BUS, *car, *dbc, "--monitor", "frictoin"], "did you mean 'friction'")
    refused(capsys, ["live", *BUS, *car, *dbc, "--log", tmp_path / "no" / "x.mf4"], "there is no folder")
    same = ["--log", tmp_path / "x.mf4", "--memory", tmp_path / "x.mf4"]
    refused(capsys, ["live", *BUS, *car, *dbc, *same], "would overwrite")


@pytest.mark.parametrize(
    ("option", "name", "sentence"),
    [
        ("--log", "x.csv", "--log writes .mf4, not 'x.csv': name it x.mf4; tierod convert writes other formats"),
        ("--report", "x.pdf", "--report writes .html, not 'x.pdf': name it x.html"),
    ],
)
def test_live_refuses_endings_that_promise_another_format(tmp_path, capsys, option, name, sentence):
    car = ["--vehicle", "midsize-eps", "--dbc", database_file(tmp_path)]
    refused(capsys, ["live", *BUS, *car, option, tmp_path / name], sentence)


def test_live_refuses_the_fault_memory_of_another_car(tmp_path, capsys):
    from tierod.diagnosis.fault_memory import FaultMemory

    with FaultMemory.changing(tmp_path / "car.json", "another-car") as memory:
        memory.begin_cycle()
        memory.end_cycle()
    car = ["--vehicle", "midsize-eps", "--dbc", database_file(tmp_path)]
    refused(capsys, ["live", *BUS, *car, "--memory", tmp_path / "car.json"], "another-car", "midsize-eps")


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


def test_options_reach_the_interface(tmp_path, capsys):
    """`preserve_timestamps` is an option of python-can's virtual bus."""
    import can

    from tierod.live.buses import Address, open_bus

    sender = open_bus(Address("virtual", "options", options={"preserve_timestamps": True}))
    bus = can.Bus(interface="virtual", channel="options")
    sender.send(can.Message(arbitration_id=1, timestamp=5.0))
    assert bus.recv(1.0).timestamp == 5.0
    bus.shutdown()
    sender.shutdown()
    car = ["--vehicle", "midsize-eps", "--dbc", database_file(tmp_path)]
    refused(capsys, ["live", *BUS, *car, "--interface-option", "fd"], "expected NAME=VALUE")


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
    refused(capsys, ["replay", tmp_path / "drive.parquet", *BUS, "--loss", "2"], "--loss is a share between 0 and 1")
    refused(capsys, ["replay", tmp_path / "drive.parquet", *BUS], "has no signal of the databases")
    refused(capsys, ["replay", tmp_path / "none.mf4", *BUS], "there is no file")
    dbc = ["--dbc", database_file(tmp_path), "--speed", "0"]
    (tmp_path / "bare.csv").write_text("time,yaw_rate\n" + "".join(f"{k / 100},{k}\n" for k in range(50)))
    refused(
        capsys, ["replay", tmp_path / "bare.csv", *BUS, *dbc], "'yaw_rate' has no unit, and ESP.yaw_rate is sent in"
    )
    (tmp_path / "gaps.csv").write_text(
        "time,yaw_rate [rad/s],vehicle_speed [m/s]\n" + "".join(f"{k / 100},{k if k % 2 else ''},\n" for k in range(50))
    )
    refused(
        capsys, ["replay", tmp_path / "gaps.csv", *BUS, *dbc], "nothing can be sent: 25 frames were not sent, since"
    )
