"""`tierod identify vehicle`: from ordinary drives to a vehicle file, or to a reason why not."""

import json
import re
import struct
import tomllib
from pathlib import Path

import pytest

from report_pages import Page
from shared_data import shared_data
from tierod.cli import main
from tierod.cli.identify import _next
from tierod.core.errors import InputError
from tierod.io.writers import write
from tierod.report.identification.vehicle import VEHICLE
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED
from tierod_lab.ground.courses.roads import City, Country
from tierod_lab.ground.run import CHANNELS, drive
from tierod_lab.ground.sensors import SensorSet

TEXT = (SHIPPED / "midsize-eps.toml").read_text(encoding="utf-8")
OPEN = ("steering_ratio", "front_cornering_stiffness")


def guessed():
    """A file that knows all but steering ratio and front stiffness exactly."""
    car = tomllib.loads(TEXT)["parameters"]
    text = TEXT
    for name in ("mass", "yaw_inertia", "front_distance", "rear_distance", "rear_cornering_stiffness"):
        old = f"standard_deviation = {car[name]['standard_deviation']:g}"
        at = text.index(f"[parameters.{name}]")
        text = text[:at] + re.sub(r"standard_deviation = \S+", "standard_deviation = 0.0", text[at:], count=1)
        assert old not in text[at : at + 40]
    text = text.replace("value = 0.06451612903225806", "value = 0.069  # a guess")
    for name in ("tyre_friction", "rear_friction_ratio", "rear_relaxation_ratio"):
        text += f'\n[parameters.{name}]\nvalue = 1.0\nunit = ""\nstandard_deviation = 0.0\nsource = "assumed"\n'
    return text


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drives")
    sensors = SensorSet.production().only(CHANNELS)
    write(drive(minutes=2.0, seed=21, sensors=sensors, roads=(City(), Country())), folder / "town.parquet")
    (folder / "car.toml").write_text(guessed(), encoding="utf-8")
    return folder


def identify(folder, *arguments):
    return main(["identify", "vehicle", str(folder / "town.parquet"), *arguments])


def test_what_was_learnt_goes_into_the_same_file_and_the_rest_stays(folder, capsys):
    car, page = folder / "own.toml", folder / "page.html"
    car.write_text(guessed(), encoding="utf-8")
    places = ["--vehicle", str(car), "-o", str(car), "--report", str(page), "--json"]
    assert identify(folder, *places) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["subject"] == "vehicle"
    found = {each["name"]: each for each in document["parameters"]}
    kinds = {each["name"]: each["kind"] for each in document["judged"]}
    assert kinds["steering_ratio"] == "learnt"
    assert found["steering_ratio"]["value"] == pytest.approx(1.0 / 15.5, rel=0.03)
    written = load(car)
    assert written["steering_ratio"] == pytest.approx(found["steering_ratio"]["value"], rel=1e-6)
    assert "town.parquet (" in written.parameters["steering_ratio"].source
    assert "# a guess" in car.read_text(encoding="utf-8")
    for name in written.parameters:
        if name not in found:
            assert written.parameters[name] == load(folder / "car.toml").parameters[name]
    texts = Page(page.read_text(encoding="utf-8")).texts
    assert {"Drives and their zeros", "Noises of sensors, model and road"} <= set(texts)


def test_the_terminal_says_what_stays_and_why(folder, capsys):
    assert identify(folder, "--vehicle", str(folder / "car.toml"), "--free", "steering_ratio,relaxation_length") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "Kept as before" in out
    assert "Drives and their zeros" in out
    assert "parameters learnt from 1 drive" in out


def test_the_next_command_judges_the_drives_with_the_written_file():
    drives = [Path("a drive.csv"), Path("b.csv")]
    assert _next(drives, Path("car.toml")) == "go on with: tierod diagnose 'a drive.csv' b.csv --vehicle car.toml"
    read_so = {"start": 10.0, "dbc": [Path("a.dbc")], "channel_map": Path("m.toml")}
    assert _next(drives, Path("car.toml"), **read_so).endswith("--from 10.0 --dbc a.dbc --map m.toml")
    assert "--output" in _next(drives, None)


def test_a_contradiction_leaves_the_file_as_it_was(folder, capsys):
    text = guessed().replace("value = 0.069 ", "value = 0.045 ").replace("deviation = 0.003\n", "deviation = 0.0005\n")
    (folder / "wrong.toml").write_text(text, encoding="utf-8")
    target = folder / "never.toml"
    assert identify(folder, "--vehicle", str(folder / "wrong.toml"), "-o", str(target), "--free", "steering_ratio") == 2
    assert "steering_ratio is 0.045 ± 0.0005 before" in capsys.readouterr().err
    assert not target.exists()


def test_a_shipped_file_is_not_written_over(folder, capsys):
    assert identify(folder, "--vehicle", "midsize-eps", "-o", str(SHIPPED / "midsize-eps.toml")) == 3
    assert "give --output" in capsys.readouterr().err


DBC = """VERSION ""
NS_ :
BS_:
BU_: CAR
BO_ 36 MOTION: 8 CAR
 SG_ YawRate : 0|16@1- (0.01,0) [0|0] "deg/s" CAR
 SG_ Speed : 16|16@1- (0.01,0) [0|0] "km/h" CAR
"""
MAP = """[signals.yaw_rate]
source = "MOTION.YawRate"
[signals.vehicle_speed]
source = "MOTION.Speed"
"""


@pytest.fixture
def bus(tmp_path, monkeypatch):
    """A CAN log of a minute, its database, and a vehicle file that names that and a channel map."""
    monkeypatch.chdir(tmp_path)
    frames = (struct.pack("<hhi", k % 100, 3600, 0).hex().upper() for k in range(600))
    lines = [f"({0.1 * k + 1e9:.6f}) can0 024#{frame}\n" for k, frame in enumerate(frames)]
    for name, text in (("can.log", "".join(lines)), ("car.dbc", DBC), ("car.channels.toml", MAP)):
        Path(name).write_text(text, encoding="utf-8")
    named = '[channels]\nmap = "car.channels.toml"\ndbc = "car.dbc"\n'
    Path("car.toml").write_text(f"{guessed()}\n{named}", encoding="utf-8")
    return tmp_path


@pytest.fixture
def looked_at(monkeypatch):
    """Recordings that an identification would look at."""
    seen = {}

    def refuse(car, recordings, *_):
        seen.update(recordings)
        raise InputError("seen")

    monkeypatch.setattr("tierod.report.identification.subject_of", lambda name: VEHICLE._replace(identify=refuse))
    return seen


def test_recordings_are_read_as_a_diagnosis_reads_them(bus, looked_at, capsys):
    assert main(["identify", "vehicle", "can.log", "--vehicle", "car.toml"]) == 3
    assert "seen" in capsys.readouterr().err
    speed = looked_at["can.log"]["vehicle_speed"]
    assert speed.values == pytest.approx(10.0)
    assert len(speed.values) == 600
    # Another vehicle names neither database nor map.
    other = ["--vehicle", "midsize-eps", "--dbc", "car.dbc", "--map", "car.channels.toml"]
    assert main(["identify", "vehicle", "can.log", *other, "--from", "10", "--to", "20"]) == 3
    first, last = looked_at["can.log"].span
    assert 10.0 <= first <= last <= 20.0


def test_a_stretch_outside_the_recording_is_refused(bus, capsys):
    assert main(["identify", "vehicle", "can.log", "--vehicle", "car.toml", "--from", "100"]) == 3
    assert "can.log has no data from 100 s on" in capsys.readouterr().err


def test_a_real_bus_log_is_read_by_the_database_that_the_vehicle_file_names(capsys):
    log = str(shared_data("rav4_highway_minute", "can.log"))
    assert main(["identify", "vehicle", log, "--vehicle", "rav4", "--free", "front_cornering_stiffness"]) in (0, 2)
    assert "can.log" in capsys.readouterr().out
