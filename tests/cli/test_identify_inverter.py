"""`tierod identify inverter`, and a diagnosis with the vehicle file that it writes."""

import json
import tomllib

import pytest

from tierod.cli import main
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.io.writers import write
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED
from tierod_lab.ground.motor import Inverter
from tierod_lab.papers.motor_angle.bench import to_and_fro

NAMES = (
    "motor_current_alpha",
    "motor_current_beta",
    "motor_target_voltage_alpha",
    "motor_target_voltage_beta",
    "motor_angle_mechanical",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inverter")
    drive = to_and_fro(95, 5.0, inverter=Inverter(dead_time=1e-6, forward_drop=0.7, knee_current=2.5))
    channels = {
        name: Channel(name, drive.time, values, SIGNALS[name].unit)
        for name, values in zip(NAMES, drive.commanded.T, strict=True)
    }
    write(Recording(channels), folder / "drive.parquet")
    (folder / "bench.toml").write_bytes((SHIPPED / "motor-bench.toml").read_bytes())
    return folder


def test_it_writes_what_a_diagnosis_then_has_nothing_to_say_about(folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    drive, found = str(folder / "drive.parquet"), folder / "found.toml"
    vehicle = str(folder / "bench.toml")
    main(["diagnose", drive, "--monitor", "motor-angle", "--vehicle", vehicle, "--json"])
    before = json.loads(capsys.readouterr().out)["findings"][0]
    assert any("the inverter's knee is at 2.5 A, not at 1 A" in each for each in before["warnings"])
    assert main(["identify", "inverter", drive, "--vehicle", vehicle, "-o", str(found), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["subject"] == "inverter"
    values = {each["name"]: each["value"] for each in result["parameters"]}
    assert values == pytest.approx({"inverter_voltage_loss": 0.83, "inverter_knee_current": 2.5}, rel=0.01)
    assert load(found)["inverter_knee_current"] == pytest.approx(values["inverter_knee_current"], rel=1e-6)
    assert tomllib.loads(found.read_text(encoding="utf-8"))["parameters"]["motor_flux"]["value"] == 0.0085
    main(["diagnose", drive, "--monitor", "motor-angle", "--vehicle", str(found), "--json"])
    after = json.loads(capsys.readouterr().out)["findings"][0]
    assert not any("not at" in each for each in after["warnings"])
    assert any("the commanded ones" in each for each in after["warnings"])


def test_it_prints_a_table(folder, capsys):
    assert main(["identify", "inverter", str(folder / "drive.parquet"), "--vehicle", str(folder / "bench.toml")]) == 0
    printed = capsys.readouterr().out
    assert "inverter_voltage_loss" in printed
    assert "inverter_knee_current" in printed
