"""What is known of a vehicle before drives identify it."""

from __future__ import annotations

import pytest

from tierod.methods.identification.drive_model import DriveNoises
from tierod.methods.identification.vehicle_judgement import NOT_SEEN, kept
from tierod.methods.identification.vehicle_priors import held_distances, priors_of
from tierod.vehicles import QUANTITIES
from tierod.vehicles.vehicle import Parameter
from tierod_lab.papers.own_car.brochure import brochure_car


def looked_for(vehicle, *free):
    return {each.name for each in priors_of(vehicle, DriveNoises(), free=free)}


def test_distances_of_a_brochure_are_known_better_than_drives_show_them():
    car = brochure_car("car", "midsize", 1500.0, 2.7)
    assert held_distances(car) == ("rear_distance",)
    assert not {"front_distance", "rear_distance"} & looked_for(car)
    assert {"steering_ratio", "front_cornering_stiffness", "sensor_forward"} < looked_for(car)


def test_a_distance_that_is_asked_for_or_hardly_known_is_looked_for():
    car = brochure_car("car", "midsize", 1500.0, 2.7)
    assert "rear_distance" in looked_for(car, "rear_distance")
    wide = Parameter("rear_distance", car["rear_distance"], QUANTITIES["rear_distance"].unit, 0.3, "a guess")
    car.parameters["rear_distance"] = wide  # type: ignore[index]
    assert "rear_distance" in looked_for(car)


def test_a_distance_that_is_held_keeps_value_and_spread_and_says_what_to_do():
    each = kept("rear_distance", 1.5, 0.09)
    assert (each.kind, each.value, each.deviation) == (NOT_SEEN, 1.5, pytest.approx(0.09))
    assert "weigh the axles" in each.text
