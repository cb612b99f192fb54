"""Scenarios, cars and courses in words."""

import json

import pytest

from tierod_lab.ground import courses
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.faults import (
    AtDistance,
    AtTime,
    Drift,
    Fault,
    Intermittent,
    Offset,
    Outlier,
    Step,
    TotalLoss,
    When,
    Within,
)
from tierod_lab.ground.faults.reading import fault_in_words
from tierod_lab.ground.scenarios import load
from tierod_lab.ground.scenarios.plants import car_document, course_document, facts, scenario_document


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (Fault("yaw_rate", Offset(0.1), AtTime(3.0)), "yaw_rate offset 0.1 rad/s, from 3 s on"),
        (Fault("yaw_rate", Drift(0.1), duration=4.0), "yaw_rate drift 0.1 rad/s/s, all the time, for 4 s"),
        (Fault("yaw_rate", TotalLoss(), Within(1.0, 2.0)), "yaw_rate total-loss, from a time between 1 s and 2 s on"),
        (Fault("yaw_rate", Outlier(0.5), AtDistance(50.0)), "yaw_rate outlier 0.5, from 50 m on, for 1 s"),
        (Fault("driver_torque", Intermittent(Offset(2.0))), "driver_torque intermittent 2 N*m, all the time"),
        (
            Fault("steering.friction.level", Step("8 N*m"), When("vehicle_speed > 3 m/s", 0.5), name="rusty"),
            "rusty: steering.friction.level step 8 N*m, when vehicle_speed > 3 m/s for 0.5 s",
        ),
    ],
)
def test_a_fault_in_words(fault, words):
    assert fault_in_words(fault) == words


def test_the_facts_of_a_scenario_name_what_differs_from_the_car_and_every_fault():
    result = facts(load("slalom-winter-tyres"))
    assert ("", "tyres = winter") in result
    assert next(text for label, text in result if label == "fault").startswith("wheel_speed_front_left drop-out")
    assert ("", "steering.mesh.play = 0.1 mm") in facts(load("rack-with-lash"))
    assert "scatter" in dict(facts(load("worn-sensors-in-town")))


def test_documents_are_plain_data():
    scenario = scenario_document(load("mixed-drive-friction-step"))
    assert (scenario["car"], scenario["course"], scenario["seconds"]) == ("midsize-eps", "mixed", 780.0)
    car = car_document(catalogue.load("small-eps"))
    mass = next(each for each in car["parameters"] if each["name"] == "chassis.mass")
    assert (mass["value"], mass["unit"]) == (1050.0, "kg")
    assert mass["source"].startswith("assumed")
    course = course_document(courses.load("slalom"))
    assert course["kind"] == "slalom"
    json.dumps([scenario, car, course], allow_nan=False)
