"""`tierod identify vehicle`: from ordinary drives to a vehicle file, or to a reason why not."""

import json
import re
import tomllib
from pathlib import Path

import pytest

from report_pages import Page
from tierod.cli import main
from tierod.cli.identify import _next
from tierod.io.writers import write
from tierod.proving_ground.courses.natural import City, Country
from tierod.proving_ground.drives import CHANNELS, drive
from tierod.proving_ground.sensors import SensorSet
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED

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
    out = capsys.readouterr().out
    assert "Kept as before" in out
    assert "Drives and their zeros" in out
    assert "parameters learnt from 1 drive" in out


def test_the_next_command_judges_the_drives_with_the_written_file():
    drives = [Path("a drive.csv"), Path("b.csv")]
    assert _next(drives, Path("car.toml"), None) == "go on with: tierod diagnose 'a drive.csv' b.csv --vehicle car.toml"
    assert _next(drives, Path("car.toml"), Path("m.toml")).endswith("--map m.toml")
    assert "--output" in _next(drives, None, None)


def test_a_contradiction_leaves_the_file_as_it_was(folder, capsys):
    text = guessed().replace("value = 0.069 ", "value = 0.045 ").replace("deviation = 0.003\n", "deviation = 0.0005\n")
    (folder / "wrong.toml").write_text(text, encoding="utf-8")
    target = folder / "never.toml"
    assert identify(folder, "--vehicle", str(folder / "wrong.toml"), "-o", str(target)) == 2
    assert "steering_ratio is 0.045 ± 0.0005 before" in capsys.readouterr().err
    assert not target.exists()


def test_a_shipped_file_is_not_written_over(folder, capsys):
    assert identify(folder, "--vehicle", "midsize-eps", "-o", str(SHIPPED / "midsize-eps.toml")) == 3
    assert "give --output" in capsys.readouterr().err
