import shlex
from dataclasses import replace

import numpy as np
import pytest

from tierod.cli import main
from tierod.core.errors import ParameterError
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.vehicles import VEHICLES, load, shipped
from tierod_lab.ground import drive


def test_lists_what_is_shipped(capsys):
    assert main(["vehicles"]) == 0
    printed = capsys.readouterr().out
    for name in shipped():
        assert name in printed


@pytest.mark.parametrize("name", shipped())
def test_shows_sources_and_what_it_is_not_good_for(name, capsys):
    assert main(["vehicles", name]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    vehicle = load(name)
    assert "Not good for" in printed
    for line in vehicle.not_good_for:
        assert line in printed
    for parameter in vehicle.parameters:
        assert parameter in printed


@pytest.mark.parametrize("name", ["midsize-eps", "rav4"])
def test_prints_a_file_to_begin_with_that_finds_the_files_of_the_vehicle(name, capsys, tmp_path):
    assert main(["vehicles", name, "--toml"]) == 0
    mine = tmp_path / "mine.toml"
    mine.write_text(capsys.readouterr().out, encoding="utf-8")
    copy, original = load(mine), load(name)
    assert copy.rows() == original.rows()
    if name == "rav4":
        assert copy.channel_map.samefile(original.channel_map)
        assert copy.database.samefile(original.database)


def test_a_vehicle_file_that_moved_finds_its_map_beside_it_or_says_what_is_missing(tmp_path):
    text = VEHICLES["midsize-eps"].read_text(encoding="utf-8")
    text += '\n[channels]\nmap = "/home/somebody/maps/car.channels.toml"\n'
    (tmp_path / "car.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ParameterError, match="put it beside the vehicle file"):
        load(tmp_path / "car.toml")
    own = tmp_path / "car.channels.toml"
    own.write_text('[signals.yaw_rate]\nsource = "yaw"\n', encoding="utf-8")
    assert load(tmp_path / "car.toml").channel_map.samefile(own)


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


def test_takes_the_channel_map_beside_it_and_one_that_is_named(tmp_path):
    (tmp_path / "car.channels.toml").write_text(MAP)
    (tmp_path / "maps").mkdir()
    assert main(["new", "car.toml", "--class", "small"]) == 0
    assert main(["new", "maps/van.toml", "--class", "van", "--map", "car.channels.toml"]) == 0
    assert load("car.toml").channel_map.samefile("car.channels.toml")
    assert load("maps/van.toml").channel_map.samefile("car.channels.toml")


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
def short_drives(tmp_path_factory):
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
        (
            ["town", "short", "imu", "gone"],
            {"identify": ["town", "gone"], "diagnose": ["town", "short", "gone"], "inspect": ["imu"]},
        ),
        ([], {"identify": ["DRIVE"], "diagnose": ["DRIVE"]}),
    ],
)
def test_recommends_for_each_recording_what_works(short_drives, names, expected, monkeypatch, capsys):
    monkeypatch.chdir(short_drives)
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


TITLES = {
    "steering_wheel_angle": ("Lenkradwinkel", np.pi / 180.0),
    "driver_torque": ("Handmoment", 1.0),
    "motor_torque": ("EPS_Motormoment", 1.0),
    "vehicle_speed": ("Fahrzeuggeschwindigkeit", 1.0 / 3.6),
    "yaw_rate": ("Gierrate", -np.pi / 180.0),
    "lateral_acceleration": ("Querbeschleunigung", 1.0),
}
"""German titles, and the SI value of one unit of the column: the yaw rate counts right as positive."""


def test_six_commands_lead_from_a_raw_file_with_foreign_titles_and_a_brochure_to_the_report(tmp_path, capsys):
    aligned = drive(minutes=3.0, seed=5).align(list(TITLES), 100.0, maximum_age=0.1)
    table = aligned.values / np.array([factor for _, factor in TITLES.values()])
    header = ",".join(["Zeit", *(title for title, _ in TITLES.values()), "Kilometerstand"])
    columns = np.column_stack([aligned.time, table, np.full(len(aligned.time), 4711.0)])
    np.savetxt("fahrt vom montag.csv", columns, delimiter=",", header=header, comments="", fmt="%.6f")
    words, ran = ["inspect", "fahrt vom montag.csv", "--write-map", "car.channels.toml"], []
    while words and len(ran) < 6:
        assert main([*words, *(["mass=1.6 t", "wheelbase=2.83"] if words[0] == "new" else [])]) in (0, 1, 2)
        ran.append(words[0])
        printed = capsys.readouterr().out
        lines = [line for line in printed.splitlines() if line.startswith(("go on with: ", "or judge at once: "))]
        words = shlex.split(lines[-1].partition(": ")[2])[1:] if lines else None
    assert (ran[0], ran[-1]) == ("inspect", "diagnose")
    assert "report: " in printed
    (page,) = tmp_path.glob("*.html")
    assert "friction" in page.read_text(encoding="utf-8")
    found = read("fahrt vom montag.csv", channel_map=load("car.toml").channel_map, names=list(TITLES))
    for name, values in zip(TITLES, aligned.values.T, strict=True):
        good = np.isfinite(values)
        assert found[name].values[: len(good)][good] == pytest.approx(values[good], abs=1e-4), name
