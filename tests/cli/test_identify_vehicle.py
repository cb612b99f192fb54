"""`tierod identify vehicle`: from ordinary drives to a vehicle file, or to a reason why not."""

import json
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from report_pages import Page
from tierod.cli import main
from tierod.core.recording import Recording
from tierod.io.writers import write
from tierod.monitors.condition.definition import CONDITION
from tierod.monitors.condition.limits import limits_of
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED
from tierod_lab.ground.courses.roads import City, Country
from tierod_lab.ground.run import CHANNELS, drive
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.papers.condition.drives import Drive
from tierod_lab.papers.condition.recorded import recorded

TEXT = (SHIPPED / "midsize-eps.toml").read_text(encoding="utf-8")


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


def test_a_contradiction_leaves_the_file_as_it_was(folder, capsys):
    text = guessed().replace("value = 0.069 ", "value = 0.045 ").replace("deviation = 0.003\n", "deviation = 0.0005\n")
    (folder / "wrong.toml").write_text(text, encoding="utf-8")
    target = folder / "never.toml"
    assert identify(folder, "--vehicle", str(folder / "wrong.toml"), "-o", str(target), "--free", "steering_ratio") == 2
    assert "steering_ratio is 0.045 ± 0.0005 before" in capsys.readouterr().err
    assert not target.exists()


DEMONSTRATOR = (SHIPPED / "smartload.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def healthy_drives(tmp_path_factory):
    """A healthy drive in two files, the second one with a gap, another with a lost wheel speed, and a vehicle file."""
    healthy_drives = tmp_path_factory.mktemp("healthy")
    drive = recorded(Drive("round-0", 170.0, 2, 902))
    parts = {"first": drive.slice(stop=80.0), "second": drive.slice(80.0)}
    wheel = parts["second"]["wheel_speed_rear_right"]
    lost = replace(wheel, values=np.where((wheel.time > 110.0) & (wheel.time < 115.0), 0.0, wheel.values))
    parts["lost"] = parts["second"].with_channels([lost])
    without = {name: each for name, each in parts["second"].channels.items() if not name.startswith("wheel_speed")}
    parts["no-wheels"] = Recording(without)
    for name, part in parts.items():
        write(part, healthy_drives / f"{name}.parquet")
    (healthy_drives / "copy.parquet").write_bytes((healthy_drives / "second.parquet").read_bytes())
    (healthy_drives / "mine.toml").write_text(
        DEMONSTRATOR.replace("[parameters.mass]", "# weighed\n[parameters.mass]"), "utf-8"
    )
    return healthy_drives


@pytest.fixture
def short(monkeypatch):
    """A minute gives the parameters, and another one the limits: enough to see what is written, not how well."""
    monkeypatch.setattr("tierod.monitors.condition.calibration.FOR_PARAMETERS", 62.0)
    monkeypatch.setattr("tierod.monitors.condition.calibration.LEAST_HOURS", 0.015)
    monkeypatch.setattr("tierod.monitors.condition.limits.LEAST_HOURS", 0.015)


def thresholds(healthy_drives, *names, arguments=()):
    files = [str(healthy_drives / f"{name}.parquet") for name in names]
    return main(["identify", "thresholds", *files, *arguments])


def test_parameters_and_limits_go_into_the_vehicle_file_and_replace_older_ones(healthy_drives, short, capsys):
    car, page = healthy_drives / "car.toml", healthy_drives / "page.html"
    older = (healthy_drives / "mine.toml").read_text("utf-8") + "\n[thresholds.residuals]\nhours = 1.0\n"
    assert "[thresholds.condition]" in older
    car.write_text(older, "utf-8")
    places = ["--vehicle", str(car), "--in-place", "--report", str(page), "--json"]
    assert thresholds(healthy_drives, "first", "second", arguments=[*places, "--false-alarms", "1 per 100000 h"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["schema"] == "tierod.identification/1"
    assert result["explained"]
    assert set(result["thresholds"]) == {"condition", "residuals", "residuals-printed"}
    found = {each["name"]: each["value"] for each in result["parameters"]}
    assert load(car)["mass"] == pytest.approx(found["mass"], rel=1e-6)
    assert min(limits_of(load(car)).fast) > 0.0
    assert "Limits" in Page(page.read_text(encoding="utf-8")).texts
    for variant in ("bank", "rules"):
        assert CONDITION.variants[variant].open(load(car), 100.0, None).calibrated
    text = car.read_text(encoding="utf-8")
    assert "# weighed\n[parameters.mass]" in text
    for of in result["thresholds"]:
        assert text.count(f"[thresholds.{of}]") == 1
    kept = tomllib.loads(text)["thresholds"]["condition"]
    assert kept["hours_between_alarms"] > 0.999e5
    assert kept["hours_between_alarms"] > kept["hours_at_least"]


def test_a_drive_with_a_fault_is_named_and_nothing_is_written(healthy_drives, short, capsys):
    before = sorted(healthy_drives.iterdir())
    places = ["--vehicle", "smartload", "-o", str(healthy_drives / "doubtful.toml")]
    assert thresholds(healthy_drives, "first", "lost", arguments=places) == 2
    result = " ".join(capsys.readouterr().err.split())
    assert "doubtful.toml is not written: not fault-free" in result
    assert "lost.parquet: wheel_speed_rear_right" in result
    assert sorted(healthy_drives.iterdir()) == before


@pytest.mark.parametrize(
    ("names", "arguments", "words"),
    [
        (["first"], [], "limits need 15 more, better an hour"),
        (["first", "second"], [], "standing does not count"),
        (["first", "no-wheels"], [], "no-wheels.parquet has neither wheel_speed_rear_left nor"),
        (["second", "copy"], [], "second.parquet and copy.parquet hold the same drive"),
        (["first", "first"], [], "given twice"),
        (["first"], ["--free", "mass"], "leave --free out"),
        (["first"], ["--false-alarms", "seldom"], '"1 per 10000 h"'),
        (["first"], ["--false-alarms", "0 per 10 h"], '"1 per 10000 h"'),
        (["first"], ["--in-place"], "is shipped with tierod"),
        (["first"], ["--report", "{healthy_drives}/first.parquet"], "the page would overwrite"),
    ],
)
def test_what_cannot_be_meant_is_refused_before_the_search(healthy_drives, capsys, names, arguments, words):
    before = {path: path.read_bytes() for path in healthy_drives.iterdir()}
    places = ["-o", str(healthy_drives / "new.toml")] if "--in-place" not in arguments else []
    given = [each.format(healthy_drives=healthy_drives) for each in arguments]
    assert thresholds(healthy_drives, *names, arguments=["--vehicle", "smartload", *places, *given]) == 3
    assert words in " ".join(capsys.readouterr().err.split())
    assert {path: path.read_bytes() for path in healthy_drives.iterdir()} == before
