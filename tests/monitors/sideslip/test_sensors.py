"""Signs, units, offset of the yaw rate and the one motion of a drive, from made-up signals."""

import math

import numpy as np
import pytest

from tierod.models.single_track import SingleTrack
from tierod.monitors.sideslip.sensors import SensorsOverDrive
from tierod.physics.single_track import steady_yaw_gain, understeer_gradient
from tierod.vehicles import load

RATE = 100.0
OFFSET = math.radians(1.7)
CAR = load("midsize-eps").parameters_for(SingleTrack.Parameters)
NAMES = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "longitudinal_acceleration", "angle", "torque")


def over(columns, pieces=1):
    sensors, length = SensorsOverDrive(CAR, RATE), len(columns["vehicle_speed"])
    whole = [np.broadcast_to(columns.get(name, np.nan), length) for name in NAMES]
    for cut in np.array_split(np.arange(length), pieces):
        sensors.add(*(each[cut] for each in whole))
    return sensors


def turns(offset=0.0, stand=0.0, yaw=1.0, speed=1.0, acceleration=1.0, bank=0.0, angle=0.0, pieces=1, circle=0.0):
    """Turns at a steady speed after a standstill, with signals of wrong scale or zero."""
    time = np.arange(0.0, 40.0, 1.0 / RATE)
    v = np.where(time < stand, 0.0, 12.0)
    turn = np.where(time < stand, 0.0, circle + 0.15 * np.sin(2.0 * time))
    return over(
        {
            "vehicle_speed": speed * v,
            "yaw_rate": yaw * turn + offset,
            "lateral_acceleration": acceleration * (v * turn + bank),
            "angle": turn / SingleTrack.steady_yaw_gain(12.0, CAR) + angle,
        },
        pieces,
    )


def driven(pieces=1, **changed):
    """A drive of two minutes at changing speed, with noise; a function of the signals gives changed ones."""
    time = np.arange(12_000) / RATE
    speed = 14.0 + 6.0 * np.sin(0.21 * time) + 2.0 * np.sin(0.53 * time)
    angle = 0.03 * np.sin(0.37 * time) + 0.015 * np.sin(0.83 * time + 1.0)
    gradient = understeer_gradient(
        CAR.mass, CAR.front_distance, CAR.rear_distance, CAR.front_cornering_stiffness, CAR.rear_cornering_stiffness
    )
    yaw_rate = steady_yaw_gain(speed, CAR.front_distance + CAR.rear_distance, gradient) * angle
    noise = np.random.default_rng(1).normal(size=(5, len(time)))
    columns = (speed, yaw_rate, speed * yaw_rate, np.gradient(speed) * RATE, angle)
    sizes = (0.05, 0.002, 0.05, 0.05, 1e-4)
    made = {
        name: each + size * noise[k] for k, (name, each, size) in enumerate(zip(NAMES, columns, sizes, strict=False))
    }
    return over(made | {name: change(made) for name, change in changed.items()}, pieces)


def test_signals_that_fit_show_nothing_however_they_are_cut():
    for sensors in (driven(), driven(13)):
        assert sensors.turned() == ()
        assert sensors.wrong_motion() is sensors.wrong_unit() is sensors.offset() is None
    assert driven(13).beside_turns() == pytest.approx(driven().beside_turns(), rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("stand", [0.0, 3.0])
def test_an_offset_is_reported_standing_and_driving(stand):
    found = turns(offset=OFFSET, stand=stand, pieces=3).offset()
    assert found.value == pytest.approx(OFFSET, rel=0.05)
    assert ("stands" in found.shown_by) == (stand > 0.0)


def steady(*parts):
    """Parts of (seconds, speed, yaw rate, lateral acceleration) with straight wheels."""
    rows = np.concatenate([np.tile(part[1:], (round(part[0] * RATE), 1)) for part in parts])
    return over(dict(zip(NAMES, rows.T, strict=False)) | {"angle": 0.0})


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"yaw": 57.3}, "degrees"),
        ({"yaw": 1.0 / 57.3}, "product of speed and yaw rate"),
        ({"speed": 3.6}, "product of speed and yaw rate"),
        ({"acceleration": 1.0 / 9.81}, "product of speed and yaw rate"),
    ],
)
def test_a_wrong_unit_is_reported(change, word):
    assert word in turns(**change, pieces=2).wrong_unit()
    assert turns(bank=0.3, offset=0.01).wrong_unit() is None


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"yaw_rate": lambda there: -there["yaw_rate"]}, ("yaw_rate",)),
        ({"lateral_acceleration": lambda there: -there["lateral_acceleration"]}, ("lateral_acceleration",)),
        (
            {"longitudinal_acceleration": lambda there: -there["longitudinal_acceleration"]},
            ("longitudinal_acceleration",),
        ),
        ({"vehicle_speed": lambda there: there["vehicle_speed"] + 3e3 * (there["angle"] % 0.002)}, ("vehicle_speed",)),
        (
            {"vehicle_speed": lambda there: there["angle"], "angle": lambda there: there["vehicle_speed"]},
            ("vehicle_speed",),
        ),
        *(({name: lambda _: np.nan}, ()) for name in NAMES[1:5]),
    ],
)
def test_the_signal_that_contradicts_the_motion_of_the_others_is_named(changed, named):
    found = driven(**changed).wrong_motion()
    assert (() if found is None else found.rests_on) == named
