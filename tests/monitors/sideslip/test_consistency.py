"""Which signal or parameter disagrees with the others, and by how much, on a made-up drive without tyres' slip."""

import math
from functools import cache

import numpy as np
import pytest

from tierod.monitors.sideslip.consistency import Tolerances, consistency_of
from tierod.monitors.sideslip.observables import WHEELS, ObservablesOverDrive
from tierod.vehicles import load
from tierod_lab.papers.own_car.brochure import brochure_car

RATE = 50.0
TIME = np.arange(9000) / RATE
CAR = brochure_car("midsize", "midsize", 1550.0, 2.7)


@cache
def signals():
    """Turns at 4 to 16 m/s of a car that follows its file, with noise."""
    speed = 10.0 + 4.0 * np.sin(0.21 * TIME) + 2.0 * np.sin(0.53 * TIME)
    yaw = (0.2 * np.sin(0.37 * TIME) + 0.15 * np.sin(0.83 * TIME + 1.0)) * 8.0 / speed
    wheelbase, rear, track = CAR["front_distance"] + CAR["rear_distance"], CAR["rear_distance"], CAR["track_width"]
    changed = np.gradient(yaw) * RATE
    noise = np.random.default_rng(1).normal(size=(9, len(TIME)))
    there = {
        "vehicle_speed": speed + 0.02 * noise[0],
        "yaw_rate": yaw + 0.002 * noise[1],
        "lateral_acceleration": 0.97 * speed * yaw + (rear - 0.2) * changed + 0.05 * noise[2],
        "longitudinal_acceleration": np.gradient(speed) * RATE + 0.05 * noise[3],
        "angle": wheelbase * yaw / speed + 0.0035 * speed * yaw + 2e-4 * noise[4],
    }
    sides = zip(WHEELS, (-0.5, 0.5, -0.5, 0.5), strict=True)
    return there | {name: speed + side * track * yaw + 0.03 * noise[5 + at] for at, (name, side) in enumerate(sides)}


def over(vehicle=CAR, pieces=1, missing=(), added=None, **factors):
    """The consistency of the drive with a file, some signals scaled and then others added to some."""
    there = {name: factors.get(name, 1.0) * values for name, values in signals().items()}
    there |= {name: there[name] + more for name, more in (added or {}).items()}
    there |= {name: np.full(len(TIME), math.nan) for name in missing}
    drive = ObservablesOverDrive(RATE)
    for at in np.array_split(np.arange(len(TIME)), pieces):
        piece = {name: values[at] for name, values in there.items()}
        drive.add(piece, piece.pop("angle"))
    return consistency_of(drive, vehicle, Tolerances())


def test_a_drive_that_fits_its_file_has_nothing_wrong_however_it_is_cut():
    assert over().wrong() is None
    assert over(pieces=13).evidence() == pytest.approx(over().evidence(), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("factor", [0.8, 1.25])
@pytest.mark.parametrize("name", ["yaw_rate", "vehicle_speed", "lateral_acceleration"])
def test_a_signal_of_another_scale_is_named_with_it(name, factor):
    wrong = over(**{name: factor}).wrong()
    assert wrong is not None
    assert wrong.decisive
    assert name in wrong.names
    best = over(**{name: factor}).explanations[0]
    assert best.name == name
    assert math.exp(best.size) == pytest.approx(factor, rel=0.1)


@pytest.mark.parametrize(
    ("added", "factors", "wrong"),
    [
        ({"yaw_rate": TIME / 300.0}, {"wheel_speed_rear_right": 0.75}, "yaw_rate"),
        ({}, {"angle": 2.0, "wheel_speed_rear_right": 0.5}, "steering_wheel_angle"),
        ({"longitudinal_acceleration": 0.0}, {"lateral_acceleration": 1.5, "vehicle_speed": 0.7}, "vehicle_speed"),
    ],
)
def test_of_two_wrong_signals_none_is_accused_alone(added, factors, wrong):
    found = over(added=added, **factors).wrong()
    assert wrong in found.names
    assert len(found.names) > 2
    assert "more than one of" in found.sentence
    assert "times the right value" not in found.sentence


@pytest.mark.parametrize("name", ["smartload", "revsted-car"])
def test_the_file_of_another_car_is_named(name):
    wrong = over(load(name)).wrong()
    assert wrong is not None
    assert wrong.decisive
