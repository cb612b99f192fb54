"""Slip of whole axles, and a slow shift of the steering angle's zero, on drives of virtual cars."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.condition.motion_alone import MOTION, SETS, drive, hard, with_slip
from said import said
from tierod.core.findings import Status
from tierod.core.recording import Channel, Recording
from tierod.monitors.condition.signals import FRONT_WHEELS, WHEELS
from tierod.monitors.diagnose import diagnose
from tierod_lab.ground.cars.catalogue import load as car_of
from tierod_lab.ground.courses.course import Adhesion, Along
from tierod_lab.ground.courses.roads import Bend, Circuit, Halt, Straight
from tierod_lab.ground.courses.way import Pace
from tierod_lab.ground.faults import injected
from tierod_lab.ground.run import run
from tierod_lab.papers.condition.drives import OFFSET, Injected

SPIN, LOCK = (24.0, 25.5), (45.0, 45.8)


def turned(part, names, window, factor):
    """Some wheels at another speed than the car's, which they reach within 0.2 s."""
    start, end = window

    def share(time):
        return 1.0 + (factor - 1.0) * np.interp(time, [start, start + 0.2, end - 0.2, end], [0.0, 1.0, 1.0, 0.0])

    return part.with_channels(
        [Channel(each, part[each].time, part[each].values * share(part[each].time), part[each].unit) for each in names]
    )


@pytest.fixture(scope="module")
def sound():
    return drive(5, 70.0)


@pytest.fixture(scope="module")
def slipped(sound):
    return turned(turned(sound, FRONT_WHEELS, SPIN, 3.0), WHEELS, LOCK, 0.0)


def said_of(part, only="all"):
    """Elements at fault, sentences on slip, and the diagnosis."""
    made = Recording({name: part[name] for name in SETS[only]})
    found = diagnose(made, "rav4", "condition", spread=False)
    names = [each.name for each in found.elements if each.status in (Status.FAULT, Status.SUSPECT)]
    return names, [each for each in found.findings[0].warnings if each.startswith("wheels of the")], found


@pytest.mark.parametrize("only", ["all", "without accelerations"])
def test_wheels_that_spun_or_locked_are_stated_and_no_sensor_is_accused(slipped, only):
    names, (fact,), found = said_of(slipped, only)
    assert (names, found.findings[0].status) == ([], Status.HEALTHY)
    spun, skidded = fact.split(", ")
    assert spun.startswith("wheels of the front axle spun from 24.")
    assert skidded.startswith("wheels of the rear axle skidded from 45.")


def test_wheels_that_spin_at_a_start_on_ice_accuse_no_sensor():
    """A car that starts twice with too much force, where the road is icy at its halts."""
    halt = Halt(100.0, 2.0)
    ice = tuple(Adhesion(window=Along(at - 8.0, at + 8.0, 1.0), left=0.15, right=0.15) for at in (8.0, halt.place))
    parts = (Straight(120.0), Bend(40.0, 1.0), Straight(200.0), Bend(60.0, -1.0))
    pace = Pace(3.0, 2.0, 0.25)
    way = Circuit(sections=parts, pace=pace, time=40.0, speed=14.0, halts=(halt,), conditions=ice)
    car = car_of("rav4-like").block
    car = replace(car, powertrain=replace(car.powertrain, front_share=1.0, greatest_drive_force=7000.0))
    made = run(car, way, 40.0, 5).recording
    wheels = [np.abs(made[name].values).max() for name in (FRONT_WHEELS[0], WHEELS[0])]
    assert wheels[0] > 1.2 * wheels[1]
    names, facts, _ = said_of(Recording({name: made[name] for name in MOTION}))
    assert names == []
    assert facts
    assert all("front axle spun" in each for each in facts)


@pytest.mark.parametrize(
    ("sensor", "size", "start"),
    [("yaw_rate", 0.1, 30.0), ("wheel_speed_rear_left", 2.0, 30.0), ("wheel_speed_rear_left", 2.0, 15.0)],
)
def test_a_fault_that_begins_after_a_slip_or_lasts_through_it_is_named(slipped, sensor, size, start):
    assert said_of(injected(slipped, [Injected(sensor, OFFSET, size, start, 40.0).fault]))[0] == [sensor]


def test_one_wheel_at_that_speed_is_a_fault_and_two_that_stay_so_are_no_endless_slip(sound):
    assert said_of(turned(sound, FRONT_WHEELS[:1], SPIN, 3.0))[:2] == ([FRONT_WHEELS[0]], [])
    (fact,) = said_of(turned(sound, FRONT_WHEELS, (20.0, 65.0), 3.0))[1]
    assert fact.startswith("wheels of the front axle spun from 20.")
    assert " to 35." in fact


@pytest.mark.parametrize("driven_axle", ["front", "rear"])
def test_slip_in_hard_starts_and_stops_accuses_no_acceleration_and_a_wrong_one_is_named(driven_axle):
    """Slip of up to .36 of the driven axle under its drive, and of both axles under brakes."""
    part = with_slip(hard(110, driven_axle, 40.0), 0.3, driven_axle)
    assert "longitudinal_acceleration" not in said_of(part)[0]
    fault = Injected("longitudinal_acceleration", OFFSET, 2.5, 20.0, 40.0).fault
    assert said_of(injected(hard(110, driven_axle, 40.0), [fault]))[0] == ["longitudinal_acceleration"]


@pytest.mark.parametrize(("factor", "lasting", "named"), [(1.3, 1.0, False), (1.3, 3.0, True), (0.7, 1.0, True)])
def test_a_wheel_that_spins_alone_in_hard_acceleration_is_no_fault_of_its_sensor(factor, lasting, named):
    made = hard(131, "front", 40.0)
    along = made["longitudinal_acceleration"]
    pushed = np.convolve(along.values > 2.7, np.ones(100), "same") > 99.0
    at = float(along.time[np.flatnonzero(pushed & (along.time > 8.0))[0]])
    names, _, found = said_of(turned(made, FRONT_WHEELS[:1], (at, at + lasting), factor))
    assert names == ([FRONT_WHEELS[0]] if named else [])
    (wheel,) = (each for each in found.elements if each.name == FRONT_WHEELS[0])
    assert named or (wheel.status, wheel.cause.startswith("the wheel slipped alone")) == (Status.NOT_TESTABLE, True)


def shifted(recording, size, name="steering_wheel_angle", times=(80.0, 140.0, 500.0, 560.0)):
    """The recording with a sensor whose zero moves by a size between two times, and back between two more [s]."""
    read = recording[name]
    moved = np.interp(read.time - read.time[0], times, [0.0, size, size, 0.0])
    return Recording({**recording.channels, name: replace(read, values=read.values + moved)})


def test_a_slow_shift_names_the_steering_angle_with_its_size_and_a_fault_free_drive_names_nothing():
    finding = said_of(shifted(drive(3), 0.4))[2].findings[0]
    assert finding.status is Status.FAULT
    assert "steering wheel angle sensor: positive offset of" in said(finding)
    assert finding.estimate.value == pytest.approx(0.4, rel=0.1)
    assert 85.0 < finding.since < 150.0
    for made in (drive(3), shifted(drive(3), 0.18)):
        assert said_of(made)[2].findings[0].status is Status.HEALTHY


@pytest.mark.parametrize("end", [180.0, 500.0])
def test_a_small_slow_offset_of_the_yaw_rate_is_named_with_its_span_and_does_not_accuse_the_angle(end):
    names, _, found = said_of(shifted(drive(3), 0.05, "yaw_rate", (70.0, 90.0, end, end + 20.0)))
    finding = found.findings[0]
    assert names == ["yaw_rate"]
    assert "yaw rate sensor: positive offset of" in said(finding)
    assert finding.estimate.value == pytest.approx(0.05, rel=0.2)
    assert "steering angle and wheel speeds fit" in finding.cause
    (episode,) = (each for element in found.elements for each in element.episodes)
    assert 70.0 < episode.start < 95.0
    assert episode.end is None if end > 240.0 else 175.0 < episode.end < 205.0


def test_an_angle_that_shifts_while_the_yaw_rate_leaves_the_wheels_is_one_of_two_suspects():
    found = said_of(shifted(shifted(drive(3), -0.03, "yaw_rate"), 0.15))[2].findings[0]
    assert found.status is Status.SUSPECT
    assert found.headline == "Sensors and actuators: suspect, yaw rate or steering wheel angle"
    assert "the wheel speeds do not show which of them is wrong" in found.cause
