"""What virtual cars are made of, by name."""

import importlib
import pkgutil

import pytest

from tierod.core.errors import ParameterError
from tierod.core.toml import Document, kind_name
from tierod_lab.ground import cars
from tierod_lab.ground.cars.active_front_car import ActiveFrontCar
from tierod_lab.ground.cars.car import Car
from tierod_lab.ground.cars.catalogue import KINDS, choices, parts_of, with_parts
from tierod_lab.ground.cars.eps_car import EpsCar
from tierod_lab.ground.chassis import SingleTrack
from tierod_lab.ground.steering.column_eps import WormGear

NOWHERE = Document({}, "", "test")


def test_every_car_can_be_named_in_a_file():
    for module in pkgutil.iter_modules(cars.__path__):
        importlib.import_module(f"{cars.__name__}.{module.name}")
    found, waiting = set(), [Car]
    while waiting:
        below = waiting.pop().__subclasses__()
        waiting += below
        found.update(below)
    assert {kind_name(each) for each in found} <= set(KINDS)


@pytest.mark.parametrize("name", KINDS)
def test_what_stands_in_a_place_is_among_its_choices(name):
    car = KINDS[name]()
    known = choices(car)
    for place, part in parts_of(car).items():
        assert part in known[place]
        assert len(known[place]) > 1


def test_an_outer_part_is_replaced_before_what_is_inside_it():
    parts = {"steering.motor.ripple": "ripple", "steering": "rack-eps", "chassis": "single-track"}
    car = with_parts(EpsCar(), parts, NOWHERE)
    assert isinstance(car.chassis, SingleTrack)
    assert parts_of(car)["steering.motor.ripple"] == "ripple"
    assert "steering.worm_gear" not in parts_of(car)


def test_an_optional_part_comes_and_goes():
    car = with_parts(EpsCar(), {"steering.worm_gear": "worm-gear"}, NOWHERE)
    assert isinstance(car.steering.worm_gear, WormGear)
    assert with_parts(car, {"steering.worm_gear": "none"}, NOWHERE) == EpsCar()


def test_a_part_that_a_car_cannot_do_without_is_refused_at_its_line():
    document = Document.parse("[car.parts]\nsteering.column.torsion_bar = 'none'", "drive.toml")
    with pytest.raises(ParameterError, match="drive.toml, line 2: the column of an ActiveFront has no torsion bar"):
        with_parts(ActiveFrontCar(), {"steering.column.torsion_bar": "none"}, document, ("car", "parts"))
