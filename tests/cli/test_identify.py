"""`tierod identify column`: from recordings of a bench to a vehicle file and a page."""

import json
import tomllib

import pytest

from report_pages import Page, charts
from tierod.cli import main
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.io.writers import write
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED
from tierod_lab.ground.motor import Inverter
from tierod_lab.papers.motor_angle.bench import to_and_fro

TEXT = (SHIPPED / "column-bench.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two experiments of the virtual bench, and a vehicle file whose friction is not right."""
    folder = tmp_path_factory.mktemp("bench")
    for name, seconds in (("locked-sweep", "5"), ("multisine", "5")):
        path = str(folder / f"{name}.parquet")
        assert main(["simulate", f"column-bench-{name}", "-o", path, "--seconds", seconds, "--json"]) == 0
    (folder / "eps.toml").write_text(TEXT.replace("value = 0.1\n", "value = 0.07  # a guess\n"), encoding="utf-8")
    return folder


def identify(folder, *arguments):
    files = [str(folder / "locked-sweep.parquet"), str(folder / "multisine.parquet")]
    return main(["identify", "column", *files, "--vehicle", str(folder / "eps.toml"), *arguments])


def test_writes_vehicle_file_page_and_json(folder, capsys):
    target, page = folder / "found.toml", folder / "page.html"
    assert identify(folder, "-o", str(target), "--report", str(page), "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert result["schema"] == "tierod.identification/1"
    assert result["converged"]
    found = {each["name"]: each for each in result["parameters"]}
    assert found["motor_friction"]["value"] == pytest.approx(0.1, rel=0.02)
    assert found["motor_friction"]["before"] == 0.07
    assert found["motor_damping"]["value"] == pytest.approx(1.483924848e-3, rel=0.02)
    assert [each["left_out"] for each in result["leave_one_out"]] == ["locked-sweep.parquet", "multisine.parquet"]
    text = page.read_text(encoding="utf-8")
    assert {"matching-0", "matching-1", "friction-curve", "residuals"} == set(charts(text))
    assert "motor_friction_stiffness" in Page(text).texts
    car = load(target)
    for name, each in found.items():
        parameter = car.parameters[name]
        assert parameter.value == pytest.approx(each["value"], rel=1e-6)
        assert parameter.standard_deviation == pytest.approx(each["standard_deviation"], rel=0.01)
        assert "multisine.parquet (" in parameter.source
        assert "tierod" in parameter.source
    text = target.read_text(encoding="utf-8")
    assert "  # a guess" in text
    before = tomllib.loads((folder / "eps.toml").read_text(encoding="utf-8"))["parameters"]
    assert tomllib.loads(text)["parameters"]["motor_inertia"] == before["motor_inertia"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-o", "{folder}/eps.toml"], "give --in-place"),
        (["-o", "{folder}/multisine.parquet"], "the vehicle file would overwrite"),
        (["-o", "{folder}/x.toml", "--in-place"], "two places"),
        (["-o", "{folder}/x.toml", "--report", "{folder}/x.toml"], "the page would overwrite"),
        (["--report", "{folder}/absent/x.html"], "create the folder first"),
        (["--free", "motor_frcition"], "motor_friction"),
        (["--in-place", "--vehicle", "column-bench"], "give --output"),
        (["--vehicle", "rav4"], "motor_friction"),
        (["{folder}/multisine.parquet"], "given twice"),
    ],
)
def test_slips_of_the_command_line(folder, capsys, arguments, words):
    assert identify(folder, *(each.format(folder=folder) for each in arguments)) == 3
    assert words in capsys.readouterr().err


def test_a_wheel_held_by_hands_is_seen_and_nothing_is_written(folder, capsys):
    text = 'name = "held"\ndescription = "Held."\ncar = "column-bench"\nseconds = 4\n'
    text += '[course]\nname = "bench-multisine"\nwheel = "held"\n[sensors]\npreset = "bench"\n'
    (folder / "held.toml").write_text(text, encoding="utf-8")
    assert main(["simulate", str(folder / "held.toml"), "-o", str(folder / "held.parquet"), "--json"]) == 0
    capsys.readouterr()
    target = folder / "held-found.toml"
    arguments = [str(folder / "held.parquet"), "--vehicle", "column-bench", "-o", str(target), "--json"]
    assert main(["identify", "column", *arguments, "--free", "motor_friction"]) == 2
    result = json.loads(capsys.readouterr().out)
    assert not result["explained"]
    assert any("check for hands on the wheel" in remark for remark in result["remarks"])
    assert result["vehicle_file"] is None
    assert not target.exists()


MOTOR = (SHIPPED / "motor-bench.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def motor_folder(tmp_path_factory):
    """A drive of the virtual bench, and a vehicle file whose resistance is not right."""
    folder = tmp_path_factory.mktemp("motor")
    assert main(["simulate", "motor-bench-multisine", "-o", str(folder / "drive.parquet"), "--json"]) == 0
    (folder / "motor.toml").write_text(MOTOR.replace("value = 0.05\n", "value = 0.07  # a guess\n"), encoding="utf-8")
    return folder


def identify_motor(folder, *arguments):
    drive, vehicle = str(folder / "drive.parquet"), str(folder / "motor.toml")
    return main(["identify", "motor", drive, "--vehicle", vehicle, *arguments])


def test_a_motor_is_written_to_vehicle_file_page_and_json(motor_folder, capsys):
    target, page = motor_folder / "found.toml", motor_folder / "page.html"
    assert identify_motor(motor_folder, "-o", str(target), "--report", str(page), "--json") == 0
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


NAMES = (
    "motor_current_alpha",
    "motor_current_beta",
    "motor_target_voltage_alpha",
    "motor_target_voltage_beta",
    "motor_angle_mechanical",
)


@pytest.fixture(scope="module")
def inverter_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inverter")
    drive = to_and_fro(95, 5.0, inverter=Inverter(dead_time=1e-6, forward_drop=0.7, knee_current=2.5))
    channels = {
        name: Channel(name, drive.time, values, SIGNALS[name].unit)
        for name, values in zip(NAMES, drive.commanded.T, strict=True)
    }
    write(Recording(channels), folder / "drive.parquet")
    (folder / "bench.toml").write_bytes((SHIPPED / "motor-bench.toml").read_bytes())
    return folder


def test_it_writes_what_a_diagnosis_then_has_nothing_to_say_about(inverter_folder, capsys, monkeypatch):
    monkeypatch.chdir(inverter_folder)
    drive, found = str(inverter_folder / "drive.parquet"), inverter_folder / "found.toml"
    vehicle = str(inverter_folder / "bench.toml")
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
