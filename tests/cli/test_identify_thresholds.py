"""`tierod identify thresholds`: from healthy drives to a vehicle file, or to a reason why not."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from report_pages import Page
from tierod.cli import main
from tierod.core.recording import Recording
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.monitors.condition.definition import CONDITION
from tierod.monitors.condition.limits import limits_of
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED
from tierod_lab.papers.condition.drives import Drive
from tierod_lab.papers.condition.recorded import recorded

TEXT = (SHIPPED / "smartload.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A healthy drive in two files, the second one with a gap, another with a lost wheel speed, and a vehicle file."""
    folder = tmp_path_factory.mktemp("healthy")
    drive = recorded(Drive("round-0", 170.0, 2, 902))
    parts = {"first": drive.slice(stop=80.0), "second": drive.slice(80.0)}
    wheel = parts["second"]["wheel_speed_rear_right"]
    lost = replace(wheel, values=np.where((wheel.time > 110.0) & (wheel.time < 115.0), 0.0, wheel.values))
    parts["lost"] = parts["second"].with_channels([lost])
    without = {name: each for name, each in parts["second"].channels.items() if not name.startswith("wheel_speed")}
    parts["no-wheels"] = Recording(without)
    for name, part in parts.items():
        write(part, folder / f"{name}.parquet")
    (folder / "copy.parquet").write_bytes((folder / "second.parquet").read_bytes())
    (folder / "mine.toml").write_text(TEXT.replace("[parameters.mass]", "# weighed\n[parameters.mass]"), "utf-8")
    return folder


@pytest.fixture
def short(monkeypatch):
    """A minute gives the parameters, and another one the limits: enough to see what is written, not how well."""
    monkeypatch.setattr("tierod.monitors.condition.calibration.FOR_PARAMETERS", 62.0)
    monkeypatch.setattr("tierod.monitors.condition.calibration.LEAST_HOURS", 0.015)
    monkeypatch.setattr("tierod.monitors.condition.limits.LEAST_HOURS", 0.015)


def thresholds(folder, *names, arguments=()):
    files = [str(folder / f"{name}.parquet") for name in names]
    return main(["identify", "thresholds", *files, *arguments])


def test_parameters_and_limits_go_into_the_vehicle_file_and_replace_older_ones(folder, short, capsys):
    car, page = folder / "car.toml", folder / "page.html"
    older = (folder / "mine.toml").read_text("utf-8") + "\n[thresholds.residuals]\nhours = 1.0\n"
    assert "[thresholds.condition]" in older
    car.write_text(older, "utf-8")
    places = ["--vehicle", str(car), "--in-place", "--report", str(page), "--json"]
    assert thresholds(folder, "first", "second", arguments=[*places, "--false-alarms", "1 per 100000 h"]) == 0
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


def test_a_drive_with_a_fault_is_named_and_nothing_is_written(folder, short, capsys):
    before = sorted(folder.iterdir())
    places = ["--vehicle", "smartload", "-o", str(folder / "doubtful.toml")]
    assert thresholds(folder, "first", "lost", arguments=places) == 2
    result = " ".join(capsys.readouterr().err.split())
    assert "doubtful.toml is not written: not fault-free" in result
    assert "lost.parquet: wheel_speed_rear_right" in result
    assert sorted(folder.iterdir()) == before


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
        (["first"], ["--report", "{folder}/first.parquet"], "the page would overwrite"),
    ],
)
def test_what_cannot_be_meant_is_refused_before_the_search(folder, capsys, names, arguments, words):
    before = {path: path.read_bytes() for path in folder.iterdir()}
    places = ["-o", str(folder / "new.toml")] if "--in-place" not in arguments else []
    given = [each.format(folder=folder) for each in arguments]
    assert thresholds(folder, *names, arguments=["--vehicle", "smartload", *places, *given]) == 3
    assert words in " ".join(capsys.readouterr().err.split())
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_recordings_are_not_written_over(folder, capsys):
    path = folder / "copy.parquet"
    before = path.read_bytes()
    assert main(["identify", "thresholds", str(path), "--vehicle", "smartload", "-o", str(path)]) == 3
    assert "would overwrite" in capsys.readouterr().err
    assert path.read_bytes() == before
    assert len(read(path).names) > 10
