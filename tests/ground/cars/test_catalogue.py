"""Virtual cars as files."""

from dataclasses import is_dataclass

import numpy as np
import pytest

from chassis_replay import Replay, courses
from shared_data import shared_data
from tierod.core.errors import ParameterError
from tierod.core.fields import numbers
from tierod.core.graph import scan
from tierod.core.toml_document import Document
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod_lab.ground.cars.catalogue import Choice, by_path, load, shipped
from tierod_lab.ground.chassis import SingleTrack, TwoTrack
from tierod_lab.ground.steering.friction import LuGre

FILE = """\
name = "mine"
description = "A car of my own."
source = "measured in my garage"
kind = "eps-car"
good_for = ["tests"]
not_good_for = ["roads"]
tyres = "winter"

[parts]
steering = "rack-eps"
"steering.friction.law" = "lu-gre"

[parameters]
chassis.mass = { value = "1.5 t", source = "weighed" }
"chassis.front.tyre.radius" = { value = "300 mm", source = "rolled" }
steering.friction.level = "3 N*m"
"""


@pytest.fixture
def mine(tmp_path):
    def make(text=FILE):
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return load(path)

    return make


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_car_says_what_it_is_and_where_its_values_come_from(name):
    car = load(name)
    assert car.name == name
    assert car.file.description.endswith(".")
    assert len(car.file.description) < 130
    assert car.file.source
    assert car.file.good_for
    assert car.file.not_good_for
    for path in {each.removesuffix(".value").removesuffix(".source") for each in by_path(car.file.parameters)}:
        assert car.source_of(path), f"{path} of {name} has no source"


@pytest.mark.parametrize("name", [name for name in shipped() if hasattr(load(name).block, "chassis")])
def test_the_parts_of_a_shipped_car_know_each_other(name):
    car = load(name).block
    chassis, driver = car.chassis, car.driver
    assert driver.wheelbase == pytest.approx(chassis.wheelbase, rel=0.02)
    assert driver.understeer_gradient == pytest.approx(chassis.understeer_gradient, abs=5e-4)
    values = {path: number.value for path, number in numbers(car).items()}
    pairs = [
        ("driver.mass", "chassis.mass", 0.02),
        ("driver.rear_distance", "chassis.rear_distance", 0.02),
        ("assist.bar_stiffness", "steering.torsion_bar.stiffness", 0.02),
        ("powertrain.wheel_radius", "chassis.front.tyre.radius", 0.02),
    ]
    if name != "active-front-steering":  # its assist is stated at the column, its steering ratio varies
        pairs += [
            ("assist.motor_ratio", "steering.motor.ratio", 1e-9),
            ("driver.steering_ratio", "steering.linkage.ratio", 0.02),
        ]
    for known, true, tolerance in pairs:
        if known in values and true in values:
            assert values[known] == pytest.approx(values[true], rel=tolerance), known


def test_a_file_of_ones_own(mine):
    car = mine()
    assert car.block.chassis.mass == 1500.0
    assert car.source_of("chassis.mass") == "weighed"
    assert car.source_of("steering.friction.level") == ""
    assert car.block.chassis.front.tyre.radius == 0.3
    assert car.block.chassis.front.tyre.cornering_stiffness == 18.0, "that of the winter tyre"
    assert car.block.steering.friction.level == 3.0
    assert isinstance(car.block.steering.friction.law, LuGre)


def test_the_shipped_cars_differ_in_what_their_names_say():
    assert isinstance(load("midsize-eps").block.chassis, TwoTrack)
    assert isinstance(load("midsize-eps-light").block.chassis, SingleTrack)
    assert type(load("midsize-rack-eps").block.steering).__name__ == "RackEps"
    assert load("small-eps").block.chassis.mass < 1200.0 < 2000.0 < load("large-rack-eps").block.chassis.mass


DOCUMENT = Document.parse("[car]\nname = 'x'\nparts.chasis = 1\ntyres = 'slicks'\nparameters.a = 2", "drive.toml")


def test_a_part_that_is_replaced_keeps_what_the_file_says(mine):
    car = mine().varied(Choice(parts={"chassis": "single-track"}), DOCUMENT)
    assert isinstance(car.chassis, SingleTrack)
    assert car.chassis.mass == 1500.0
    assert car.chassis.yaw_inertia == SingleTrack().yaw_inertia
    assert car.steering.friction.level == 3.0


def test_tyres_of_another_kind_keep_the_size():
    small = load("small-eps")
    own = small.block.chassis.front.tyre
    changed = small.varied(Choice(tyres="sport"), DOCUMENT).chassis.front.tyre
    assert (changed.radius, changed.nominal_load) == (own.radius, own.nominal_load)
    assert changed.cornering_stiffness > own.cornering_stiffness


def test_parts_may_be_left_out_or_put_in():
    car = load("midsize-eps")
    rigid = car.varied(Choice(parts={"steering": {"torsion_bar": "none"}}), DOCUMENT)
    assert rigid.steering.torsion_bar is None
    rippled = car.varied(
        Choice(parts={"steering.motor.ripple": "ripple"}, parameters={"steering.motor.ripple.share": "2 %"}), DOCUMENT
    )
    assert is_dataclass(rippled.steering.motor.ripple)
    assert rippled.steering.motor.ripple.share == 0.02


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        (
            {"parts": {"chasis": "two-track"}},
            "drive.toml, line 3: no part of the car .* 'chasis'; did you mean 'chassis'",
        ),
        ({"parts": {"chassis": "three-track"}}, "no chassis is called 'three-track'; did you mean 'two-track'"),
        ({"tyres": "wintr"}, "drive.toml, line 4: no tyres are called 'wintr'; did you mean 'winter'"),
        ({"tyres": "winter", "parts": {"chassis": "single-track"}}, "line 4: this car has no tyres to choose from"),
        ({"parameters": {"chassis.mas": 1}}, "no parameter is called 'chassis.mas'; did you mean 'chassis.mass'"),
        ({"parameters": {"chassis.mass": "-3 kg"}}, "'car.parameters.chassis.mass' is -3 kg, but has to be above 0 kg"),
        ({"parameters": {"chassis": {"mass": "3 m"}}}, "is measured in 'kg'"),
    ],
)
def test_a_wrong_variation(choice, words):
    with pytest.raises(ParameterError, match=words):
        load("midsize-eps").varied(Choice(**choice), DOCUMENT, ("car",))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("eps-car", "esp-car", "line 4: no kind of car is called 'esp-car'; did you mean 'eps-car'"),
        ('tyres = "winter"', 'tyres = "slick"', "line 7: no tyres are called 'slick'"),
        ('"rack-eps"', '"rack"', "line 10: no steering is called 'rack'; did you mean 'rack-eps'"),
        ("chassis.mass", "chassis.mss", "line 14: no parameter is called 'chassis.mss'; did you mean 'chassis.mass'"),
        ("1.5 t", "1.5 m", "line 14: 'parameters.chassis.mass' is '1.5 m', but is measured in 'kg'"),
        ("3 N*m", "-3 N*m", "line 16: .* is -3 N\\*m, but has to be at least 0 N\\*m"),
        ('source = "measured in my garage"\n', "", "'source' is missing"),
        ("kind =", "kid =", "'kid' is not known here; did you mean 'kind'"),
    ],
)
def test_a_slip_in_a_file_is_reported_with_its_line(mine, old, new, words):
    with pytest.raises(ParameterError, match=f"mine.toml.*{words}"):
        mine(FILE.replace(old, new, 1))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("midsize-esp", "no virtual car is called 'midsize-esp'; did you mean 'midsize-eps'"),
        ("absent.toml", "there is no file absent.toml of a virtual car; shipped ones: active"),
        ("folder/car", "there is no file folder/car"),
    ],
)
def test_a_car_that_is_not_there(name, words):
    with pytest.raises(ParameterError, match=words):
        load(name)


def test_the_compact_suv_follows_the_recorded_minute_of_one():
    recording = complete(read(shared_data("rav4_highway_minute", "can.log"), dbc="rav4", channel_map="rav4"))
    car = load("rav4-like").block
    first, last = recording["steering_wheel_angle"].time[[0, -1]]
    time = np.arange(first + 0.1, last - 0.1, car.step_time)
    angle, speed, yaw = (
        np.interp(time, recording[name].time, recording[name].values)
        for name in ("steering_wheel_angle", "vehicle_speed", "yaw_rate")
    )
    steer = car.steering.linkage.ratio * angle
    ours = scan(Replay(car.chassis, start_speed=float(speed[0])), courses(steer, speed))["yaw_rate"]
    assert np.degrees(np.std(ours - yaw)) < 0.3, "the zero of the gyroscope is taken out"
