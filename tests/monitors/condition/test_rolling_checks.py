"""Slip of whole axles, and a slow shift of the steering angle's zero, made up and on drives of virtual cars."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.condition.motion_alone import MOTION, SETS, drive, hard, with_slip
from said import said
from tierod.core.findings import Status
from tierod.core.recording import Channel, Recording
from tierod.models.single_track import RollingCar
from tierod.monitors.condition.rolling_checks import LEAST, AxleSlip, SteeringZero
from tierod.monitors.condition.signals import ALL_WHEELS, FRONT_WHEELS, WHEELS
from tierod.monitors.diagnose import diagnose
from tierod.physics.motion import steady_yaw_gain, understeer_gradient
from tierod.vehicles import load
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


def at_fault(found):
    return [each.name for each in found.elements if each.status in (Status.FAULT, Status.SUSPECT)]


def facts(found):
    return [each for each in found.findings[0].warnings if each.startswith("wheels of the")]


@pytest.mark.parametrize("only", ["all", "without accelerations"])
def test_wheels_that_spun_or_locked_are_stated_and_no_sensor_is_accused(slipped, only):
    part = Recording({name: slipped[name] for name in SETS[only]})
    found = diagnose(part, load("rav4"), "condition")
    assert found.findings[0].status is Status.HEALTHY
    assert not at_fault(found)
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
    assert not at_fault(found)
    assert all("front axle spun" in each for each in facts(found))
    assert facts(found)


def test_one_wheel_at_the_same_speed_is_a_fault_of_its_sensor(sound):
    found = diagnose(turned(sound, FRONT_WHEELS[:1], SPIN, 3.0), load("rav4"), "condition")
    assert at_fault(found) == [FRONT_WHEELS[0]]
    assert not facts(found)


@pytest.mark.parametrize(("sensor", "size"), [("yaw_rate", 0.1), ("wheel_speed_rear_left", 2.0)])
def test_a_fault_that_begins_after_a_slip_is_named(slipped, sensor, size):
    found = diagnose(injected(slipped, [Injected(sensor, OFFSET, size, 30.0, 40.0).fault]), load("rav4"), "condition")
    assert at_fault(found) == [sensor]


def test_a_fault_that_lasts_through_a_slip_is_named(slipped):
    fault = Injected("wheel_speed_rear_left", OFFSET, 2.0, 15.0, 40.0).fault
    found = diagnose(injected(slipped, [fault]), load("rav4"), "condition")
    assert at_fault(found) == ["wheel_speed_rear_left"]


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
    assert "longitudinal_acceleration" not in at_fault(diagnose(part, load("rav4"), "condition"))


def test_an_acceleration_that_is_wrong_in_hard_starts_and_stops_is_named():
    made = injected(hard(110, "front", 40.0), [Injected("longitudinal_acceleration", OFFSET, 2.5, 20.0, 40.0).fault])
    assert at_fault(diagnose(made, load("rav4"), "condition")) == ["longitudinal_acceleration"]


@pytest.mark.parametrize(
    ("at", "axle", "factor"), [(32.0, WHEELS, 1.2), (44.0, FRONT_WHEELS, 1.3), (50.0, WHEELS, 0.8)]
)
def test_a_brief_slip_of_an_axle_on_a_rough_road_is_no_fault_of_one_wheel(sound, at, axle, factor):
    """A slip too small and too short to be left out, of which one wheel looks noisier than the other."""
    chance = np.random.default_rng(5)
    rough = [replace(sound[each], values=sound[each].values + chance.normal(0.0, 0.12, 7000)) for each in ALL_WHEELS]
    found = diagnose(turned(sound.with_channels(rough), axle, (at, at + 0.45), factor), load("rav4"), "condition")
    assert at_fault(found) == []
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
    assert at_fault(found) == ([FRONT_WHEELS[0]] if named else [])
    (wheel,) = (each for each in found.elements if each.name == FRONT_WHEELS[0])
    assert named or (wheel.status, wheel.cause.startswith("the wheel slipped alone")) == (Status.NOT_TESTABLE, True)


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
