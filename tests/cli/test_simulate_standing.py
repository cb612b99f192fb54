"""A car that a unit computes, and that does not drive."""

from types import SimpleNamespace

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod_lab.cli.simulate import _standing

TIME = np.arange(0.0, 5.0, 0.1)


def outcome(speed, name="vehicle_speed"):
    return SimpleNamespace(recording=Recording({name: Channel(name, TIME, np.full(len(TIME), speed), "m/s")}))


def scenario(speed):
    return SimpleNamespace(course=SimpleNamespace(start=SimpleNamespace(speed=speed)))


@pytest.mark.parametrize("name", ["vehicle_speed", "truth_longitudinal_speed"])
@pytest.mark.parametrize("speed", [0.0, np.nan])
def test_a_car_that_stands_where_its_course_drives_is_said(name, speed):
    sentence = _standing(scenario(20.0), outcome(speed, name))
    assert "stands still throughout" in sentence
    assert "demand.speed" in sentence


def test_a_car_that_drives_or_shall_stand_is_not():
    assert _standing(scenario(20.0), outcome(19.0)) == ""
    assert _standing(scenario(0.0), outcome(0.0)) == ""
    assert _standing(scenario(20.0), outcome(0.0, "yaw_rate")) == ""
