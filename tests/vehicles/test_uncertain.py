"""Parameters moved within their spread, and the spread of a class of cars."""

import dataclasses
import math

import pytest

from tierod.vehicles import QUANTITIES, load, shipped
from tierod.vehicles.classes import Known
from tierod.vehicles.draft import begun
from tierod.vehicles.uncertain import (
    WatchedParameters,
    bound_distance,
    held_deviation,
    hold_spread,
    in_words,
    is_guess,
    may_move,
    moved,
    with_spread,
)


def car(**deviations):
    vehicle = load("midsize-eps")
    parameters = {
        name: dataclasses.replace(each, standard_deviation=deviations.get(name))
        for name, each in vehicle.parameters.items()
    }
    return dataclasses.replace(vehicle, parameters=parameters)


def test_a_small_spread_moves_by_differences_and_nothing_else_moves():
    vehicle = car(mass=160.0, rear_distance=0.1)
    other = moved(vehicle, {"mass": -2.0})
    assert other["mass"] == pytest.approx(1280.0)
    assert other["rear_distance"] == vehicle["rear_distance"]


def test_a_large_spread_of_a_positive_quantity_moves_by_factors():
    vehicle = car(front_cornering_stiffness=55e3)
    up, down = (moved(vehicle, {"front_cornering_stiffness": by})["front_cornering_stiffness"] for by in (1.0, -1.0))
    assert up * down == pytest.approx(vehicle["front_cornering_stiffness"] ** 2)
    assert up / vehicle["front_cornering_stiffness"] == pytest.approx(math.exp(math.sqrt(math.log(1.25))))


@pytest.mark.parametrize("by", [-2.0, -1.0, 1.0, 2.0])
def test_a_spread_of_three_hundred_per_cent_stays_within_what_a_car_can_be(by):
    vehicle = load("midsize-eps")
    wild = car(**{name: 3.0 * abs(each.value) for name, each in vehicle.parameters.items()})
    other = moved(wild, dict.fromkeys(wild.parameters, by))
    for name, each in other.parameters.items():
        low, high = QUANTITIES[name].plausible
        assert low <= each.value <= high, name


def with_wheelbase(**deviations):
    _, parameters = begun({"mass": Known(1500.0), "wheelbase": Known(2.7)}, "midsize")
    known = {each.name: each for each in parameters}
    for name, deviation in deviations.items():
        known[name] = dataclasses.replace(known[name], standard_deviation=deviation)
    return dataclasses.replace(load("midsize-eps"), parameters=known)


@pytest.mark.parametrize("by", [-2.0, 1.0])
def test_a_wheelbase_that_is_known_binds_the_distances_of_the_axles(by):
    vehicle = with_wheelbase()
    assert bound_distance(vehicle)
    other = moved(vehicle, {"rear_distance": by})
    assert other["rear_distance"] - vehicle["rear_distance"] == pytest.approx(
        by * vehicle.parameters["rear_distance"].standard_deviation
    )
    assert other["rear_distance"] + other["front_distance"] == pytest.approx(2.7)


def test_a_wheelbase_that_is_no_better_known_binds_nothing_and_no_axle_passes_the_centre():
    assert not bound_distance(with_wheelbase(wheelbase=0.2))
    assert not bound_distance(car(rear_distance=0.1, front_distance=0.1))
    other = moved(with_wheelbase(rear_distance=3.0, front_distance=3.0), {"rear_distance": 2.0})
    assert other["front_distance"] >= QUANTITIES["front_distance"].plausible[0]
    assert other["rear_distance"] + other["front_distance"] == pytest.approx(2.7)


def test_limits_and_noises_are_not_moved():
    assert may_move("rear_distance")
    assert not any(map(may_move, ("fault_friction", "nominal_friction", "yaw_rate_noise", "bank_wander_time")))


def test_reading_a_parameter_is_noted_and_asking_for_it_is_not():
    watched = WatchedParameters(load("midsize-eps").parameters)
    vehicle = dataclasses.replace(load("midsize-eps"), parameters=watched)
    assert "trail" in vehicle
    assert vehicle["mass"] == 1600.0
    assert list(watched.read) == ["mass"]
    assert vehicle.parameters["trail"].standard_deviation == 0.015
    assert list(watched.read) == ["mass", "trail"]
    assert is_guess(vehicle.parameters["mass"], 0.0)
    assert not is_guess(vehicle.parameters["mass"], 1.0)


def test_a_spread_is_held_by_whoever_says_so_and_only_where_the_file_gives_it():
    vehicle = load("midsize-eps")
    bare = dataclasses.replace(vehicle.parameters["mass"], standard_deviation=None)
    watched = WatchedParameters({**vehicle.parameters, "mass": bare})
    vehicle = dataclasses.replace(vehicle, parameters=watched)
    assert vehicle.parameters["column_damping"].standard_deviation
    assert not watched.held
    assert held_deviation(vehicle, "trail") == 0.015
    assert held_deviation(vehicle, "mass") == 0.0
    assert list(watched.held) == ["trail"]
    hold_spread(vehicle, ("mass", "yaw_inertia"))
    assert list(watched.held) == ["trail", "mass", "yaw_inertia"]


def test_a_file_without_deviations_takes_those_of_its_class_and_an_explicit_zero_stays():
    vehicle, filled = with_spread(car(rear_distance=0.0, trail=0.001))
    assert vehicle.parameters["mass"].standard_deviation == pytest.approx(0.05 * 1600.0)
    assert vehicle.parameters["rear_distance"].standard_deviation == 0.0
    assert vehicle.parameters["trail"].standard_deviation == 0.001
    assert "mass" in filled
    assert not {"rear_distance", "trail", "fault_friction"} & set(filled)
    sentence = in_words(vehicle, filled)
    assert "class 'midsize'" in sentence
    assert "standard_deviation in the vehicle file" in sentence
    assert in_words(vehicle, ()) == ""


@pytest.mark.parametrize("name", shipped())
def test_shipped_files_give_every_deviation_themselves(name):
    assert with_spread(load(name))[1] == ()
