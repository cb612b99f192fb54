"""`tierod identify motor`: from a recording of a drive to a vehicle file and a page."""

import json

import pytest

from report_pages import Page, charts
from tierod.cli import main
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED

TEXT = (SHIPPED / "motor-bench.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A drive of the virtual bench, and a vehicle file whose resistance is not right."""
    folder = tmp_path_factory.mktemp("motor")
    assert main(["simulate", "motor-bench-multisine", "-o", str(folder / "drive.parquet"), "--json"]) == 0
    (folder / "motor.toml").write_text(TEXT.replace("value = 0.05\n", "value = 0.07  # a guess\n"), encoding="utf-8")
    return folder


def identify(folder, *arguments):
    drive, vehicle = str(folder / "drive.parquet"), str(folder / "motor.toml")
    return main(["identify", "motor", drive, "--vehicle", vehicle, *arguments])


def test_writes_vehicle_file_page_and_json(folder, capsys):
    target, page = folder / "found.toml", folder / "page.html"
    assert identify(folder, "-o", str(target), "--report", str(page), "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert result["subject"] == "motor"
    assert result["explained"]
    assert result["not_identifiable"] == []
    found = {each["name"]: each for each in result["parameters"]}
    assert found["motor_resistance"]["value"] == pytest.approx(0.05, rel=0.01)
    assert found["motor_resistance"]["before"] == 0.07
    assert found["motor_friction"]["value"] == pytest.approx(0.3, rel=0.01)
    assert found["motor_friction"]["before"] is None
    warm = result["as_warm_as_recorded"]["motor_resistance"]
    assert warm["standard_deviation"] < 0.2 * found["motor_resistance"]["standard_deviation"]
    assert result["torque_ratio"]["value"] == pytest.approx(1.0, abs=0.01)
    car = load(target)
    for name, each in found.items():
        assert car.parameters[name].value == pytest.approx(each["value"], rel=1e-6)
        assert car.parameters[name].standard_deviation == pytest.approx(each["standard_deviation"], rel=0.01)
        assert "drive.parquet (" in car.parameters[name].source
    assert "  # a guess" in target.read_text(encoding="utf-8")
    text = page.read_text(encoding="utf-8")
    assert set(charts(text)) == {"torque-0"}
    assert "motor_friction_stiffness" in Page(text).texts


def test_shows_a_table_and_what_is_to_know(folder, capsys):
    assert identify(folder, "--free", "motor_inertia,motor_friction") == 0
    out = capsys.readouterr().out
    assert "Parameters before and after" in out
    assert "motor_inertia" in out
    assert "motor_resistance  " not in out
    assert "To know: no load_torque was recorded" in out


@pytest.fixture(scope="module")
def still(folder):
    """A recording in which the motor hardly turns."""
    text = 'name = "still"\ndescription = "Still."\ncar = "motor-bench"\nseconds = 3\n'
    text += '[course]\nname = "bench-multisine"\namplitude = "0.1 N*m"\n'
    (folder / "still.toml").write_text(text, encoding="utf-8")
    path = folder / "still.parquet"
    assert main(["simulate", str(folder / "still.toml"), "-o", str(path), "--json"]) == 0
    return path


def test_what_a_recording_does_not_show_is_said(still, capsys):
    assert main(["identify", "motor", str(still), "--vehicle", "motor-bench"]) == 0
    out = capsys.readouterr().out
    assert "motor_resistance" in out
    assert "motor_inertia the shaft did not turn" in " ".join(out.split())
    assert main(["identify", "motor", str(still), "--vehicle", "motor-bench", "--free", "motor_inertia"]) == 3
    assert "not identifiable here: motor_inertia" in capsys.readouterr().err


def test_slips_of_the_command_line(folder, capsys):
    assert identify(folder, "--free", "motor_interia") == 3
    assert "motor_inertia" in capsys.readouterr().err
    assert main(["identify", "moter", str(folder / "drive.parquet"), "--vehicle", "motor-bench"]) == 3
    assert "did you mean 'motor'" in capsys.readouterr().err
    assert main(["identify", "motor", str(folder / "drive.parquet"), "--vehicle", "rav4"]) == 3
    assert "motor_resistance" in capsys.readouterr().err
