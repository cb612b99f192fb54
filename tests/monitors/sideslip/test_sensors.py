"""Signs, units, offset of the yaw rate and the one motion of a drive, from made-up signals."""

import numpy as np
import pytest

from tierod.models.single_track import SingleTrack
from tierod.monitors.sideslip.sensors import SensorsOverDrive
from tierod.physics.motion import steady_yaw_gain, understeer_gradient
from tierod.vehicles import load

RATE = 100.0
CAR = load("midsize-eps").parameters_for(SingleTrack.Parameters)
NAMES = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "longitudinal_acceleration", "angle", "torque")


def over(columns, pieces=1):
    sensors, length = SensorsOverDrive(CAR, RATE), len(columns["vehicle_speed"])
    whole = [np.broadcast_to(columns.get(name, np.nan), length) for name in NAMES]
    for cut in np.array_split(np.arange(length), pieces):
        sensors.add(*(each[cut] for each in whole))
    return sensors


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
