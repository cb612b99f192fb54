"""Zero of the steering angle over a drive: a slow change of it, in closed form and on drives of a virtual car."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.condition.motion_alone import drive
from said import said
from tierod.core.findings import Status
from tierod.core.recording import Recording
from tierod.models.rolling_car import RollingCar
from tierod.monitors.condition.rolling_checks import LEAST, SteeringZero
from tierod.monitors.diagnose import diagnose
from tierod.physics.single_track import steady_yaw_gain, understeer_gradient
from tierod.vehicles import load

CAR = load("rav4")
P = CAR.parameters_for(RollingCar.Parameters)
RATE = 100.0
STEADY = 40.0
"""Time before the zero begins to move [s]: longer than one window."""


def made_up(shift, speed=10.0, yaw=0.0, wheels=0.0, seconds=120.0):
    """Wheel speeds, yaw rate and angle of a sine of .1 rad/s about a mean, whose zero moves over 10 s.

    Args:
        shift: of the zero [rad]
        speed: [m/s]
        yaw: mean yaw rate [rad/s]
        wheels: by which the rear wheels show another yaw rate [rad/s]
        seconds: of the drive
    """
    time = np.arange(round(seconds * RATE)) / RATE
    rate = yaw + 0.1 * np.sin(0.5 * time)
    gradient = understeer_gradient(
        P.mass, P.front_distance, P.rear_distance, P.front_cornering_stiffness, P.rear_cornering_stiffness
    )
    gain = P.steering_ratio * steady_yaw_gain(speed, P.front_distance + P.rear_distance, gradient)
    half = 0.5 * P.track_width * (rate + wheels)
    moved = shift * np.clip((time - STEADY) / 10.0, 0.0, 1.0)
    return time, {
        "wheel_speed_rear_left": speed - half,
        "wheel_speed_rear_right": (speed + half) * (1.0 + P.wheel_speed_difference),
        "yaw_rate": rate + P.yaw_rate_offset,
        "steering_wheel_angle": rate / gain + 0.02 + moved,
    }


def found(time, signals, pieces=1):
    check = SteeringZero(P, RATE)
    for cut in np.array_split(np.arange(len(time)), pieces):
        check.add(time[cut], {name: values[cut] for name, values in signals.items()})
    return check.found


@pytest.mark.parametrize("shift", [0.35, -0.35])
def test_a_shift_is_found_with_its_size_and_its_time_however_the_drive_is_cut(shift):
    shown = found(*made_up(shift))
    assert shown.value == pytest.approx(shift, abs=0.02)
    assert STEADY < shown.start < STEADY + 6.0
    # Two thirds of the window have moved by two thirds of the shift and more.
    assert STEADY + 10.0 < shown.found < STEADY + 35.0
    assert found(*made_up(shift), pieces=7) == shown


@pytest.mark.parametrize("change", [{"shift": 0.9 * LEAST}, {"shift": 0.35, "seconds": 55.0}])
def test_small_shifts_and_short_drives_show_none(change):
    assert found(*made_up(**change)) is None


def test_sliding_tyres_slow_driving_and_wheels_that_disagree_do_not_count():
    assert found(*made_up(3.0, speed=20.0)) is None
    assert found(*made_up(0.5, speed=4.0)) is None
    assert found(*made_up(0.5, wheels=0.1)) is None
    assert found(*made_up(0.5, yaw=0.3)) is None


def shifted(recording, size, name="steering_wheel_angle", times=(80.0, 140.0, 500.0, 560.0)):
    """The recording with a sensor whose zero moves by a size between two times, and back between two more [s]."""
    read = recording[name]
    moved = np.interp(read.time - read.time[0], times, [0.0, size, size, 0.0])
    return Recording({**recording.channels, name: replace(read, values=read.values + moved)})


def test_a_slow_shift_names_the_steering_angle_with_its_size_and_a_fault_free_drive_names_nothing():
    drove = drive(3)
    finding = diagnose(shifted(drove, 0.4), CAR, "condition").findings[0]
    assert finding.status is Status.FAULT
    assert "steering wheel angle sensor: positive offset of" in said(finding)
    assert finding.estimate.value == pytest.approx(0.4, rel=0.1)
    assert 85.0 < finding.since < 150.0
    assert diagnose(drove, CAR, "condition").findings[0].status is Status.HEALTHY


@pytest.fixture(scope="module")
def bends():
    return drive(3)


@pytest.mark.parametrize("end", [180.0, 500.0])
def test_a_small_slow_offset_of_the_yaw_rate_is_named_with_its_span_and_does_not_accuse_the_angle(bends, end):
    wrong = shifted(bends, 0.05, "yaw_rate", (70.0, 90.0, end, end + 20.0))
    found = diagnose(wrong, CAR, "condition")
    finding, states = found.findings[0], {each.name: each for each in found.elements}
    assert "yaw rate sensor: positive offset of" in said(finding)
    assert finding.estimate.value == pytest.approx(0.05, rel=0.2)
    assert "steering angle and wheel speeds fit" in finding.cause
    (episode,) = states["yaw_rate"].episodes
    assert 70.0 < episode.start < 95.0
    assert episode.end is None if end > 240.0 else 175.0 < episode.end < 205.0
    assert states["steering_wheel_angle"].status is Status.HEALTHY


def test_an_angle_that_shifts_while_the_yaw_rate_leaves_the_wheels_is_one_of_two_suspects(bends):
    found = diagnose(shifted(shifted(bends, -0.03, "yaw_rate"), 0.15), CAR, "condition").findings[0]
    assert found.status is Status.SUSPECT
    assert "yaw rate or steering wheel angle" in said(found)
    assert "the wheel speeds do not show which of them is wrong" in found.cause
