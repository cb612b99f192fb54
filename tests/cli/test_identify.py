"""`tierod identify column`: from recordings of a bench to a vehicle file and a page."""

import json
import tomllib

import pytest

from report_pages import Page, charts
from tierod.cli import main
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED

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
    _holds_what_was_found(folder, target, found)
    text = page.read_text(encoding="utf-8")
    assert {"matching-0", "matching-1", "friction-curve", "residuals"} == set(charts(text))
    assert "motor_friction_stiffness" in Page(text).texts


def _holds_what_was_found(folder, target, found):
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


def test_without_places_nothing_is_written(folder, capsys):
    before = {path: path.read_bytes() for path in folder.iterdir()}
    assert identify(folder, "--free", "motor_friction") == 0
    out = capsys.readouterr().out
    assert "Parameters before and after" in out
    assert "Leave-one-out" in out
    assert "without 2" in out
    assert "2: multisine.parquet" in out
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-o", "{folder}/eps.toml"], "give --in-place"),
        (["-o", "{folder}/multisine.parquet"], "the vehicle file would overwrite"),
        (["-o", "{folder}/x.toml", "--in-place"], "two places"),
        (["-o", "{folder}/x.toml", "--report", "{folder}/x.toml"], "the page would overwrite"),
        (["--report", "{folder}/absent/x.html"], "create the folder first"),
        (["--free", "motor_frcition"], "motor_friction"),
        (["{folder}/multisine.parquet"], "given twice"),
    ],
)
def test_slips_of_the_command_line(folder, capsys, arguments, words):
    assert identify(folder, *(each.format(folder=folder) for each in arguments)) == 3
    assert words in capsys.readouterr().err


def test_another_subject_is_refused_with_those_there_are(folder, capsys):
    assert main(["identify", "colum", str(folder / "multisine.parquet"), "--vehicle", "column-bench"]) == 3
    assert "did you mean 'column'" in capsys.readouterr().err


def test_a_shipped_vehicle_is_never_written_over(folder, capsys):
    file = str(folder / "multisine.parquet")
    assert main(["identify", "column", file, "--vehicle", "column-bench", "--in-place"]) == 3
    assert "give --output" in capsys.readouterr().err


def test_a_vehicle_without_a_column_is_refused(folder, capsys):
    assert main(["identify", "column", str(folder / "multisine.parquet"), "--vehicle", "rav4"]) == 3
    assert "motor_friction" in capsys.readouterr().err


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
