"""Which signal contradicts the motion that the others give."""

import math

import numpy as np
import pytest

from tierod.models.single_track import SingleTrack
from tierod.monitors.sideslip.sensors import MotionOverDrive
from tierod.physics.single_track import steady_yaw_gain, understeer_gradient
from tierod.vehicles import load

RATE = 100.0
TIME = np.arange(12_000) / RATE
CAR = load("midsize-eps").parameters_for(SingleTrack.Parameters)
NAMES = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "longitudinal_acceleration", "angle")


def signals():
    """A drive at changing speed through turns that come slowly."""
    speed = 14.0 + 6.0 * np.sin(0.21 * TIME) + 2.0 * np.sin(0.53 * TIME)
    angle = 0.03 * np.sin(0.37 * TIME) + 0.015 * np.sin(0.83 * TIME + 1.0)
    gradient = understeer_gradient(
        CAR.mass, CAR.front_distance, CAR.rear_distance, CAR.front_cornering_stiffness, CAR.rear_cornering_stiffness
    )
    yaw_rate = steady_yaw_gain(speed, CAR.front_distance + CAR.rear_distance, gradient) * angle
    noise = np.random.default_rng(1).normal(size=(5, len(TIME)))
    columns = (speed, yaw_rate, speed * yaw_rate, np.gradient(speed) * RATE, angle)
    sizes = (0.05, 0.002, 0.05, 0.05, 1e-4)
    return {
        name: values + size * noise[at]
        for at, (name, values, size) in enumerate(zip(NAMES, columns, sizes, strict=True))
    }


def over(pieces=1, **changed):
    motion, columns = MotionOverDrive(CAR, RATE), signals() | changed
    for piece in np.array_split(np.arange(len(TIME)), pieces):
        motion.add(*(columns[name][piece] for name in NAMES))
    return motion


def names(**changed):
    return [each.names for each in over(**changed).wrong()]


def test_a_drive_whose_signals_fit_has_nothing_wrong_however_it_is_cut():
    assert over().wrong() == ()
    assert over().yaw_rate_offset() == pytest.approx(0.0, abs=2e-3)
    assert over(13).yaw_rate_offset() == pytest.approx(over().yaw_rate_offset(), rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("name", ["yaw_rate", "lateral_acceleration"])
def test_one_that_turns_another_way_is_named(name):
    assert names(**{name: -signals()[name]}) == [(name,)]


def test_a_speed_of_noise_and_one_that_is_another_signal_are_named():
    there = signals()
    noise = np.random.default_rng(2).normal(size=len(TIME))
    assert names(vehicle_speed=there["vehicle_speed"] + 6.0 * noise) == [("vehicle_speed",)]
    assert names(vehicle_speed=there["angle"], angle=there["vehicle_speed"]) == [("vehicle_speed",)]


def test_an_acceleration_along_of_the_wrong_sign_is_named():
    assert names(longitudinal_acceleration=-signals()["longitudinal_acceleration"]) == [("longitudinal_acceleration",)]


def test_without_a_signal_nothing_is_said_of_it():
    nothing = np.full(len(TIME), math.nan)
    for name in NAMES:
        assert names(**{name: nothing}) == []


@pytest.mark.parametrize("offset", [-0.03, 0.03])
def test_an_offset_of_the_yaw_rate_is_reported_at_different_speeds(offset):
    there = signals()
    moved = over(yaw_rate=there["yaw_rate"] + offset, vehicle_speed=there["vehicle_speed"] + 2.0)
    assert moved.yaw_rate_offset() == pytest.approx(offset, abs=6e-3)
    steady = np.full(len(TIME), 15.0)
    assert over(vehicle_speed=steady, yaw_rate=there["yaw_rate"] + offset).yaw_rate_offset() == 0.0
