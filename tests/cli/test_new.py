import shlex
from dataclasses import replace

import pytest

from tierod.cli import main
from tierod.core.errors import ParameterError
from tierod.io.writers import write
from tierod.vehicles import load
from tierod_lab.ground import drive

MAP = '[signals.yaw_rate]\nsource = "Gierrate"\nunit = "deg/s"\n'


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_writes_a_file_that_loads_and_names_the_next_command(tmp_path, capsys):
    assert (
        main(["new", "car.toml", "--like", "midsize-eps", "mass=1480+-20", "wheelbase=2.68", "--drive", "a b.csv"]) == 0
    )
    car = load("car.toml")
    assert car.name == "car"
    assert car["mass"] == 1480.0
    assert all(each.standard_deviation is not None for each in car.parameters.values())
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "tierod diagnose" in line]
    assert shlex.split(line.partition(": ")[2]) == ["tierod", "diagnose", "a b.csv", "--vehicle", "car.toml"]


@pytest.mark.parametrize("given", [["motor_pole_pairs=3"], []])
def test_a_whole_number_has_no_spread(given):
    assert main(["new", "motor.toml", "--like", "motor-bench", *given]) == 0
    pairs = load("motor.toml").parameters["motor_pole_pairs"]
    assert (pairs.value, pairs.standard_deviation) == (3.0 if given else 4.0, 0.0)


def test_a_spread_of_a_whole_number_in_an_older_file_is_not_used(tmp_path):
    assert main(["new", "motor.toml", "--like", "motor-bench"]) == 0
    file = tmp_path / "motor.toml"
    head, table, rest = file.read_text().partition("[parameters.motor_pole_pairs]")
    file.write_text(head + table + rest.replace("standard_deviation = 0.0", "standard_deviation = 0.9", 1))
    assert load("motor.toml").parameters["motor_pole_pairs"].standard_deviation == 0.0
    file.write_text(file.read_text().replace("value = 4.0", "value = 4.5", 1))
    with pytest.raises(ParameterError, match=r"motor_pole_pairs is 4.5, but it is a whole number"):
        load("motor.toml")


def test_takes_the_channel_map_beside_it_and_one_that_is_named(tmp_path):
    (tmp_path / "car.channels.toml").write_text(MAP)
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "other.toml").write_text(MAP)
    assert main(["new", "car.toml", "--class", "small"]) == 0
    assert main(["new", "maps/van.toml", "--class", "van", "--map", "car.channels.toml"]) == 0
    assert load("car.toml").channel_map.samefile("car.channels.toml")
    assert load("maps/van.toml").channel_map.samefile("car.channels.toml")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["car.toml"], "--class with one of"),
        (["car.toml", "--class", "midsise"], "did you mean 'midsize'"),
        (["car.toml", "--like", "midsize"], "did you mean 'midsize-eps'"),
        (["car.toml", "--class", "van", "mas=2000"], "did you mean 'mass'"),
        (["mass=2000", "--class", "van"], "ends in .toml"),
        (["nowhere/car.toml", "--class", "van"], "nowhere"),
        (["car.toml", "--class", "van", "--map", "absent.toml"], "absent.toml"),
        (["old.toml", "--class", "van"], "--overwrite"),
    ],
)
def test_says_what_is_wrong_and_writes_nothing(arguments, sentence, tmp_path, capsys):
    (tmp_path / "old.toml").write_text("mine")
    assert main(["new", *arguments]) == 3
    assert sentence in capsys.readouterr().err
    assert (tmp_path / "old.toml").read_text() == "mine"
    assert not (tmp_path / "car.toml").exists()


def test_overwrites_where_asked(tmp_path):
    (tmp_path / "old.toml").write_text("mine")
    assert main(["new", "old.toml", "--class", "van", "--overwrite"]) == 0
    assert load("old.toml")["mass"] == 2300.0


def test_torques_in_counts_take_no_friction_from_another_car(tmp_path, capsys):
    text = '[signals.driver_torque]\nsource = "torque"\nunit = "count"\n'
    (tmp_path / "car.channels.toml").write_text(text)
    assert main(["new", "car.toml", "--class", "small", "nominal_friction=4"]) == 3
    assert "raw counts" in capsys.readouterr().err
    assert main(["new", "car.toml", "--class", "small"]) == 0
    car = load("car.toml")
    assert car.torque_unit == "count"
    assert "nominal_friction" not in car


MOTION = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "steering_wheel_angle")


@pytest.fixture(scope="module")
def drives(tmp_path_factory):
    """A drive, half a minute too short to identify from, and one without speed and steering angle."""
    folder, whole = tmp_path_factory.mktemp("drives"), drive(minutes=1.5, seed=3)
    parts = {"town": (MOTION, 90.0), "short": (MOTION, 15.0), "imu": (MOTION[1:3], 90.0)}
    for name, (signals, end) in parts.items():
        part = replace(whole, channels={each: whole[each] for each in signals}).slice(0.0, end)
        write(part, folder / f"{name}.parquet")
    return folder


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["town"], {"identify": ["town"], "diagnose": ["town"]}),
        (["short"], {"diagnose": ["short"]}),
        (["imu"], {"inspect": ["imu"]}),
        (
            ["town", "short", "imu", "gone"],
            {"identify": ["town", "gone"], "diagnose": ["town", "short", "gone"], "inspect": ["imu"]},
        ),
        ([], {"identify": ["DRIVE"], "diagnose": ["DRIVE"]}),
    ],
)
def test_recommends_for_each_recording_what_works(drives, names, expected, monkeypatch, capsys):
    monkeypatch.chdir(drives)
    given = [word for name in names for word in ("--drive", f"{name}.parquet")]
    assert main(["new", "car.toml", "--class", "midsize", "--overwrite", *given]) == 0
    lines = capsys.readouterr().out.splitlines()
    commands = [shlex.split(line.partition(": tierod ")[2]) for line in lines if ": tierod " in line]
    files = {
        verb: [each.removesuffix(".parquet") for each in words[: words.index("--vehicle")] if each != "vehicle"]
        for verb, *words in commands
    }
    assert files == expected
    refused = [line for line in lines if line.startswith("identify would refuse it: ")]
    assert len(refused) == len({"short", "imu"} & {*names})
    if names and "gone" not in names:
        assert main(commands[0]) in (0, 2)
