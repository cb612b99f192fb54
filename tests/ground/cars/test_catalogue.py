"""Virtual cars as files, and what they are made of by name."""

import pytest

from tierod.core.errors import ParameterError
from tierod.core.fields import numbers
from tierod.core.graph.trace import trace
from tierod.core.signals import SIGNALS
from tierod.core.toml import Document
from tierod_lab.ground.cars.benches import ColumnBench, MotorBench
from tierod_lab.ground.cars.catalogue import Choice, by_path, load, shipped, with_parts
from tierod_lab.ground.cars.road_cars import ActiveFrontCar, DemonstratorCar, EpsCar, PmEpsCar, SteerByWireCar
from tierod_lab.ground.chassis import SingleTrack, TwoTrack
from tierod_lab.ground.recorder import channel_names
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


DOCUMENT = Document.parse("[car]\nname = 'x'\nparts.chasis = 1\ntyres = 'slicks'\nparameters.a = 2", "drive.toml")


def test_a_part_that_is_replaced_keeps_what_the_file_says(mine):
    car = mine().varied(Choice(parts={"chassis": "single-track"}), DOCUMENT)
    assert isinstance(car.chassis, SingleTrack)
    assert car.chassis.mass == 1500.0
    assert car.chassis.yaw_inertia == SingleTrack().yaw_inertia
    assert car.steering.friction.level == 3.0


def test_a_part_that_a_car_cannot_do_without_is_refused_at_its_line():
    document = Document.parse("[car.parts]\nsteering.column.torsion_bar = 'none'", "drive.toml")
    with pytest.raises(ParameterError, match="drive.toml, line 2: the column of an ActiveFront has no torsion bar"):
        with_parts(ActiveFrontCar(), {"steering.column.torsion_bar": "none"}, document, ("car", "parts"))


ROAD = (ActiveFrontCar, DemonstratorCar, EpsCar, PmEpsCar, SteerByWireCar)
PLANTS = [kind(chassis=chassis()) for kind in ROAD for chassis in (SingleTrack, TwoTrack)]
PLANTS += [ColumnBench(), MotorBench()]


def named(plant):
    return f"{type(plant).__name__} {type(getattr(plant, 'chassis', None)).__name__}"


@pytest.mark.parametrize("plant", PLANTS, ids=named)
def test_channels_are_canonical_and_no_two_share_a_name(plant):
    columns = channel_names(plant)
    assert [name for name in columns if name not in SIGNALS and not name.startswith("truth_")] == []
    paths = trace(plant).output
    for name, places in columns.items():
        prefixes = {paths[place].rsplit(name, 1)[0] for place in places}
        assert len(prefixes) == 1, name
