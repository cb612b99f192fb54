"""Axles of which both wheels spin or lock: a fact of the drive, after which sound sensors are not accused."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.condition.motion_alone import MOTION, SETS, drive, hard, with_slip
from tierod.core.recording import Channel, Recording
from tierod.core.statuses import Status
from tierod.monitors.condition.rolling_checks import AxleSlip
from tierod.monitors.condition.signals import ALL_WHEELS, FRONT_WHEELS, WHEELS
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load
from tierod_lab.ground.cars.catalogue import load as car_of
from tierod_lab.ground.courses.circuit import Bend, Circuit, Halt, Straight
from tierod_lab.ground.courses.conditions import Adhesion, Along
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


@pytest.fixture(scope="module")
def started_on_ice():
    """Car that starts twice with too much force, where the road is icy at its halts."""
    halt = Halt(100.0, 2.0)
    ice = tuple(Adhesion(window=Along(at - 8.0, at + 8.0, 1.0), left=0.15, right=0.15) for at in (8.0, halt.place))
    parts = (Straight(120.0), Bend(40.0, 1.0), Straight(200.0), Bend(60.0, -1.0))
    pace = Pace(3.0, 2.0, 0.25)
    course = Circuit(sections=parts, pace=pace, time=40.0, speed=14.0, halts=(halt,), conditions=ice)
    car = car_of("rav4-like").block
    car = replace(car, powertrain=replace(car.powertrain, front_share=1.0, greatest_drive_force=7000.0))
    made = run(car, course, 40.0, 5).recording
    return Recording({name: made[name] for name in MOTION})


def accused(found):
    return [each.name for each in found.elements if each.status in (Status.FAULT, Status.SUSPECT)]


def facts(found):
    return [each for each in found.findings[0].warnings if each.startswith("wheels of the")]


@pytest.mark.parametrize("only", ["all", "without accelerations"])
def test_wheels_that_spun_or_locked_are_stated_and_no_sensor_is_accused(slipped, only):
    part = Recording({name: slipped[name] for name in SETS[only]})
    found = diagnose(part, load("rav4"), "condition")
    assert found.findings[0].status is Status.HEALTHY
    assert not accused(found)
    (fact,) = facts(found)
    spun, skidded = fact.split(", ")
    assert spun.startswith("wheels of the front axle spun from 24.")
    assert skidded.startswith("wheels of the rear axle skidded from 45.")


@pytest.mark.parametrize("only", ["all", "without accelerations"])
def test_wheels_that_spin_at_a_start_on_ice_accuse_no_sensor(started_on_ice, only):
    wheels = [np.abs(started_on_ice[name].values).max() for name in (FRONT_WHEELS[0], WHEELS[0])]
    assert wheels[0] > 1.2 * wheels[1]
    part = Recording({name: started_on_ice[name] for name in SETS[only]})
    found = diagnose(part, load("rav4"), "condition")
    assert not accused(found)
    assert all("front axle spun" in each for each in facts(found))
    assert facts(found)


def test_one_wheel_at_the_same_speed_is_a_fault_of_its_sensor(sound):
    found = diagnose(turned(sound, FRONT_WHEELS[:1], SPIN, 3.0), load("rav4"), "condition")
    assert accused(found) == [FRONT_WHEELS[0]]
    assert not facts(found)


@pytest.mark.parametrize(("sensor", "size"), [("yaw_rate", 0.1), ("wheel_speed_rear_left", 2.0)])
def test_a_fault_that_begins_after_a_slip_is_named(slipped, sensor, size):
    found = diagnose(injected(slipped, [Injected(sensor, OFFSET, size, 30.0, 40.0).fault]), load("rav4"), "condition")
    assert accused(found) == [sensor]


def test_a_fault_that_lasts_through_a_slip_is_named(slipped):
    fault = Injected("wheel_speed_rear_left", OFFSET, 2.0, 15.0, 40.0).fault
    found = diagnose(injected(slipped, [fault]), load("rav4"), "condition")
    assert accused(found) == ["wheel_speed_rear_left"]


def test_two_wheel_sensors_that_stay_alike_and_wrong_are_no_endless_slip(sound):
    found = diagnose(turned(sound, FRONT_WHEELS, (20.0, 65.0), 3.0), load("rav4"), "condition")
    (fact,) = facts(found)
    assert fact.startswith("wheels of the front axle spun from 20.")
    assert " to 35." in fact


def test_slips_do_not_depend_on_the_cut_into_pieces(slipped):
    time = slipped[ALL_WHEELS[0]].time
    wheels = np.column_stack([slipped[name].values for name in ALL_WHEELS])
    whole, pieces = AxleSlip(), AxleSlip()
    at_once = whole.add(time, wheels)
    cut = [pieces.add(time[k : k + 137], wheels[k : k + 137]) for k in range(0, len(time), 137)]
    assert np.array_equal(at_once, np.concatenate(cut))
    assert whole.found == pieces.found
    assert at_once.any()


@pytest.mark.parametrize("driven_axle", ["front", "rear"])
def test_slip_in_hard_starts_and_stops_accuses_no_acceleration(driven_axle):
    """Slip of up to .36 of the driven axle under its drive, and of both axles under brakes."""
    part = with_slip(hard(110, driven_axle, 40.0), 0.3, driven_axle)
    assert "longitudinal_acceleration" not in accused(diagnose(part, load("rav4"), "condition"))


def test_an_acceleration_that_is_wrong_in_hard_starts_and_stops_is_named():
    made = injected(hard(110, "front", 40.0), [Injected("longitudinal_acceleration", OFFSET, 2.5, 20.0, 40.0).fault])
    assert accused(diagnose(made, load("rav4"), "condition")) == ["longitudinal_acceleration"]


@pytest.mark.parametrize(
    ("at", "axle", "factor"), [(32.0, WHEELS, 1.2), (44.0, FRONT_WHEELS, 1.3), (50.0, WHEELS, 0.8)]
)
def test_a_brief_slip_of_an_axle_on_a_rough_road_is_no_fault_of_one_wheel(sound, at, axle, factor):
    """A slip too small and too short to be left out, of which one wheel looks noisier than the other."""
    chance = np.random.default_rng(5)
    rough = [replace(sound[each], values=sound[each].values + chance.normal(0.0, 0.12, 7000)) for each in ALL_WHEELS]
    found = diagnose(turned(sound.with_channels(rough), axle, (at, at + 0.45), factor), load("rav4"), "condition")
    assert accused(found) == []
    doubtful = [each for each in found.elements if each.status is Status.NOT_TESTABLE]
    assert {each.name for each in doubtful} <= {*axle}
    assert all(f"slipped, or two readings were wrong, from {at:.0f}." in each.cause for each in doubtful)


@pytest.mark.parametrize(("factor", "lasting", "named"), [(1.3, 1.0, False), (1.3, 3.0, True), (0.7, 1.0, True)])
def test_a_wheel_that_spins_alone_in_hard_acceleration_is_no_fault_of_its_sensor(factor, lasting, named):
    made = hard(131, "front", 40.0)
    along = made["longitudinal_acceleration"]
    pushed = np.convolve(along.values > 2.7, np.ones(100), "same") > 99.0
    at = float(along.time[np.flatnonzero(pushed & (along.time > 8.0))[0]])
    found = diagnose(turned(made, FRONT_WHEELS[:1], (at, at + lasting), factor), load("rav4"), "condition")
    assert accused(found) == ([FRONT_WHEELS[0]] if named else [])
    (wheel,) = (each for each in found.elements if each.name == FRONT_WHEELS[0])
    assert named or (wheel.status, wheel.cause.startswith("the wheel slipped alone")) == (Status.NOT_TESTABLE, True)
