"""Every shipped fault is one that a shipped car can have."""

from functools import cache

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.faults import Schedule, load, shipped
from tierod_lab.ground.faults.schedule import Schedule as Ready
from tierod_lab.ground.sensors import SensorSet


@cache
def car(name):
    return catalogue.load(name).block


def cars_of(fault):
    found = []
    for name in catalogue.shipped():
        try:
            found.append((name, Schedule([fault], car(name), SensorSet.production(), 0, 60.0)))
        except ParameterError:
            continue
    return found


@pytest.mark.parametrize("name", shipped())
def test_some_shipped_car_can_have_it(name):
    found = cars_of(load(name).fault)
    assert found, f"no shipped car can have {name}"
    assert all(isinstance(each, Ready) and each.provenance for _, each in found)


@pytest.mark.parametrize(
    "name", [each for each in shipped() if each.startswith(("friction-", "tyre", "assist", "heavy"))]
)
@pytest.mark.parametrize("kind", ["midsize-eps", "midsize-eps-light", "midsize-rack-eps"])
def test_cars_with_assist_share_what_they_have_in_common(name, kind):
    assert kind in dict(cars_of(load(name).fault))


@pytest.mark.parametrize("sensor", ["wheel-speed-rear-left", "wheel-speed-rear-right", "steering-wheel-angle",
                                    "steering-torque", "yaw-rate", "tie-rod-force"])  # fmt: skip
@pytest.mark.parametrize("kind", ["loss", "offset", "negative-offset", "outlier"])
def test_the_demonstrator_has_the_sensor_faults_of_its_paper(sensor, kind):
    ((_, schedule),) = [found for found in cars_of(load(f"{sensor}-{kind}").fault) if found[0] == "demonstrator"]
    (window,) = schedule.windows
    assert (window["start"], window["end"]) == (20.0, 21.0 if kind == "outlier" else 40.0)
    assert schedule.parameters == ()


@pytest.mark.parametrize(
    "name", ["steering-motor-1-loss", "steering-motor-2-loss", "drive-motor-left-loss", "drive-motor-right-loss"]
)
def test_the_demonstrator_has_the_actuator_faults_of_its_paper(name):
    assert [kind for kind, _ in cars_of(load(name).fault)] == ["demonstrator"]


def test_the_motor_of_a_superposition_can_be_blocked():
    ((kind, schedule),) = cars_of(load("superposition-motor-blocked").fault)
    assert kind == "active-front-steering"
    assert schedule.inputs(np.array([29.999, 30.0]))["ports.motor_lock.offset"].tolist() == [0.0, 1.0]
