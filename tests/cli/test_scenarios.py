"""`tierod scenarios`: what can be driven."""

import json

import pytest

from tierod.cli import main
from tierod_lab.ground import courses, scenarios
from tierod_lab.ground.cars import catalogue

NAMES = {"scenarios": scenarios.shipped(), "cars": catalogue.shipped(), "courses": courses.shipped()}


def printed(capsys, *arguments):
    assert main(["scenarios", *arguments]) == 0
    return capsys.readouterr().out


def test_lists_everything_that_is_shipped(capsys):
    whole = printed(capsys)
    for name in (name for names in NAMES.values() for name in names):
        assert f"\n{name} " in f"\n{whole}"


@pytest.mark.parametrize("kind", ["cars", "courses"])
def test_lists_one_kind_alone(capsys, kind):
    result = json.loads(printed(capsys, f"--{kind}", "--json"))
    assert [each["name"] for each in result[kind]] == list(NAMES[kind])
    assert list(result) == [kind]
    whole = printed(capsys, f"--{kind}")
    assert all(f"\n{name} " not in f"\n{whole}" for name in NAMES["scenarios"])


@pytest.mark.parametrize("name", NAMES["scenarios"])
def test_shows_a_scenario(capsys, name):
    whole = " ".join(printed(capsys, name).split())
    scenario = scenarios.load(name)
    for text in (scenario.description, scenario.car_name, scenario.course.name, f"tierod simulate {name}"):
        assert text in whole
    for fault in scenario.faults:
        assert fault.element in whole
    result = json.loads(printed(capsys, name, "--json"))
    assert (result["name"], result["seconds"]) == (name, scenario.duration)


@pytest.mark.parametrize("name", NAMES["cars"])
def test_shows_a_car_with_every_parameter_and_where_it_comes_from(capsys, name):
    whole = " ".join(printed(capsys, name).split())
    car = catalogue.load(name)
    for line in (car.file.description, car.file.source, *car.file.not_good_for):
        assert line in whole
    result = json.loads(printed(capsys, name, "--json"))
    assert all(each["source"] for each in result["parameters"])
    assert result["parameters"][0]["name"] in whole


@pytest.mark.parametrize("name", NAMES["courses"])
def test_shows_a_course(capsys, name):
    course = courses.load(name)
    assert course.description in " ".join(printed(capsys, name).split())
    assert json.loads(printed(capsys, name, "--json"))["duration"] == course.duration


@pytest.mark.parametrize(
    ("name", "load"),
    [
        ("mixed-drive-friction-step", scenarios.load),
        ("small-eps", catalogue.load),
        ("parking", courses.load),
    ],
)
def test_prints_a_file_to_begin_with(capsys, tmp_path, name, load):
    mine = tmp_path / f"{name}.toml"
    mine.write_text(printed(capsys, name, "--toml"), encoding="utf-8")
    ours, shipped = load(mine), load(name)
    result = ("car", "duration", "faults") if load is scenarios.load else ("block",) if load is catalogue.load else ()
    for field in result:
        assert getattr(ours, field) == getattr(shipped, field)
    assert getattr(ours, "duration", 0.0) == getattr(shipped, "duration", 0.0)


def test_a_file_of_ones_own(capsys, tmp_path):
    mine = tmp_path / "mine.toml"
    mine.write_text(printed(capsys, "slalom", "--toml"), encoding="utf-8")
    assert "ten cones" in printed(capsys, str(mine), "--courses")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--toml"], "--toml needs the name of a scenario, car or course"),
        (["slalom", "--toml", "--json"], "--toml and --json exclude each other"),
        (["--cars", "--courses"], "--cars and --courses exclude each other"),
        (["rack-with-lahs"], "or course is called 'rack-with-lahs'; did you mean 'rack-with-lash'"),
        (["--cars", "slalom"], "no virtual car is called 'slalom'"),
        (["--courses", "slalm"], "no course is called 'slalm'; did you mean 'slalom'"),
        (["absent.toml"], "there is no scenario file absent.toml"),
    ],
)  # fmt: skip
def test_wrong_use_is_reported(capsys, arguments, sentence):
    assert main(["scenarios", *arguments]) == 3
    assert sentence in capsys.readouterr().err
