"""A clock that leaps: when it is looked for, and what is taken for one."""

import numpy as np
import pytest

from tierod.core.findings import Episode
from tierod.monitors.condition.recording_checks.clock_leap import ClockLeap
from tierod.monitors.condition.recording_checks.contradictions import Problem
from tierod.monitors.condition.signals import ELEMENTS, SENSORS

TIME = np.arange(2000) / 100.0
LATE = Problem("time", ("steering_wheel_angle",), "steering angle: 0.30 s late beside the other signals", "check")


class Look:
    """In place of the look at signals: finds what it is told to, and keeps what it is shown."""

    def __init__(self, *found):
        self.found, self.shown = found, []

    def add(self, signals):
        self.shown.append(signals["yaw_rate"])

    def problems(self):
        return self.found


def leap(look, cuts=(), **declared):
    made = ClockLeap(lambda: look)
    faulty = np.zeros((len(TIME), len(ELEMENTS)), bool)
    for name, start in declared.items():
        faulty[start <= TIME, ELEMENTS.index(name)] = True
    for time, said in zip(np.split(TIME, cuts), np.split(faulty, cuts), strict=True):
        made.add(time, dict.fromkeys(SENSORS, time), said)
    return made


@pytest.mark.parametrize("cuts", [(), (600, 1000), (1200,)])
def test_two_sensors_of_one_bus_begin_the_look(cuts):
    look = Look(LATE)
    made = leap(look, cuts, steering_wheel_angle=11.5, steering_shaft_torque=12.0)
    assert np.concatenate(look.shown)[0] == 12.0
    (found,) = made.problems([Episode("", 11.5), Episode("", 12.0)])
    assert found.cause == "steering angle: 0.30 s late beside the other signals since about 12 s"


@pytest.mark.parametrize(
    "declared", [{"steering_wheel_angle": 5.0}, {"steering_wheel_angle": 5.0, "yaw_rate": 6.0}, {"drive_left": 5.0}]
)
def test_one_sensor_of_a_bus_is_a_fault(declared):
    look = Look(LATE)
    assert leap(look, **declared).problems([]) == ()
    assert look.shown == []


def test_what_is_no_shift_of_the_angle_leaves_the_faults():
    for found in ((), (LATE._replace(kind="sign"),), (LATE._replace(elements=("yaw_rate",)),)):
        made = leap(Look(*found), wheel_speed_rear_left=12.0, yaw_rate=12.0)
        assert made.problems([Episode("", 12.0)]) == ()


def test_a_fault_that_came_before_stays():
    made = leap(Look(LATE), steering_wheel_angle=12.0, steering_shaft_torque=12.0)
    assert made.problems([Episode("", 3.0), Episode("", 12.0)]) == ()
