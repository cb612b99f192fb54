"""From healthy drives to parameters and limits: what is taken, what is refused, what is doubted."""

import numpy as np
import pytest

from tierod.cli import main
from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.monitors.condition.calibration import (
    FAULTY,
    _no_wider,
    calibrate_condition,
    calibrate_motion,
    doubt_of,
    remarks_of,
    suspicions_of,
)
from tierod.monitors.condition.definition import CONDITION, condition_monitor, rolling_limits
from tierod.monitors.condition.limits import Watched, designed_on, healthy_drives, limits_of, parted
from tierod.monitors.condition.parameters import Calibration, Found
from tierod.monitors.condition.signals import OF_CARS, TARGETS, WHEELS, hypotheses, hypotheses_of_cars
from tierod.report.identification import identify
from tierod.vehicles import load
from tierod_lab.papers.own_car.cars import drawn
from tierod_lab.papers.own_car.judging import driven

CAR = load("smartload")
COUNT = len(hypotheses()) - 1


def made_up(speed, rate=100.0, times=None):
    """A recording of both wheel speeds."""
    time = np.arange(len(speed)) / rate if times is None else times
    names = ("wheel_speed_rear_left", "wheel_speed_rear_right")
    return Recording({name: Channel(name, time, np.asarray(speed, float), "m/s") for name in names})


def with_targets(rate):
    whole = made_up(driving(20.0))
    time = np.arange(round(20.0 * rate)) / rate
    return whole.with_channels(Channel(name, time, np.sin(time), "N*m") for name in TARGETS)


def driving(seconds, speed=5.0):
    return np.full(round(100.0 * seconds), speed)


def test_standing_does_not_count_and_reversing_does():
    (drive,) = healthy_drives({"a": made_up(np.concatenate([driving(20.0), driving(30.0, 0.0), driving(10.0, -3.0)]))})
    assert drive.driven == pytest.approx(30.0, abs=0.05)


@pytest.mark.parametrize("rate", [10.0, 25.0, 50.0, 100.0, 1000.0])
def test_driving_counts_by_time_at_any_rate(rate):
    (drive,) = healthy_drives({"a": made_up(np.full(round(60.0 * rate), 5.0), rate)})
    assert drive.driven == pytest.approx(60.0, abs=0.2)


@pytest.mark.parametrize("gone", WHEELS)
def test_one_rear_wheel_shows_what_is_driven(gone):
    whole = made_up(np.concatenate([driving(20.0), driving(30.0, 0.0), driving(40.0)]))
    recording = Recording({name: each for name, each in whole.channels.items() if name != gone})
    drives = healthy_drives({"a": recording})
    assert drives[0].driven == pytest.approx(60.0, abs=0.05)
    first, rest, seconds = parted(drives, 25.0)
    assert (seconds, first[0].driven, rest[0].driven) == pytest.approx((25.0, 25.0, 35.0), abs=0.05)


def test_a_long_gap_parts_a_recording_whatever_the_clock_does_in_it():
    times = np.concatenate([np.arange(2000) / 100.0, 4e6 + np.arange(3000) / 100.0])
    drives = healthy_drives({"a": made_up(np.full(5000, 5.0), times=times)})
    assert [each.driven for each in drives] == pytest.approx([20.0, 30.0], abs=0.05)
    assert {each.name for each in drives} == {"a"}


def test_the_first_seconds_of_driving_are_taken_from_as_many_drives_as_it_needs():
    drives = healthy_drives({"a": made_up(driving(20.0)), "b": made_up(driving(40.0, 4.0)), "c": made_up(driving(9.0))})
    first, rest, seconds = parted(drives, 35.0)
    assert seconds == 35.0
    assert [(each.name, round(each.driven)) for each in first] == [("a", 20), ("b", 15)]
    assert [(each.name, round(each.driven)) for each in rest] == [("b", 25), ("c", 9)]
    for name in ("wheel_speed_rear_left", "wheel_speed_rear_right"):
        assert [len(each.recording[name].values) for each in (first[1], rest[0])] == [1500, 2500]


@pytest.mark.parametrize(
    ("recordings", "message"),
    [
        ({"a": made_up(driving(400.0))}, "hold 6.7 minutes of driving, 1.5 of them for limits"),
        ({"a": made_up(driving(50.0, 0.0))}, "hold 0.0 minutes"),
        ({"a": made_up(driving(9.0)), "b": made_up(driving(9.0))}, "a and b hold the same drive"),
        ({"a": Recording({})}, "a has neither wheel_speed_rear_left nor"),
        ({"a": made_up([])}, "a has neither wheel_speed_rear_left nor"),
        ({"a": made_up(driving(20.0), rate=5.0)}, "at 5 Hz; calibration needs 10 Hz"),
        ({"a": with_targets(25.0)}, "a: the targets of the actuators are sampled at 25 Hz"),
    ],
)
def test_what_shows_too_little_is_refused_before_the_search(recordings, message):
    with pytest.raises(InputError, match=message):
        calibrate_condition(recordings, CAR)


def test_a_drive_is_suspicious_where_one_fault_explains_it_far_better():
    (drive,) = healthy_drives({"a": made_up(driving(9.0))})
    fault_free = np.full((3, 2 * COUNT), -2.0)
    faulty, jump, pair = fault_free.copy(), fault_free.copy(), fault_free.copy()
    faulty[1, COUNT + 2] = 9.0
    jump[2, 3] = 18.0
    pair[0, COUNT + 20] = 9.0
    watched = [Watched(each, 0.1) for each in (fault_free, faulty, jump, pair)]
    named = [drive._replace(name=name) for name in ("fault_free", "faulty", "jump", "pair")]
    found = suspicions_of(named, watched, hypotheses(), FAULTY)
    assert [(each.drive, each.suspect, each.ratio) for each in found] == [
        ("faulty", "yaw_rate", 3.0),
        ("jump", "steering_wheel_angle", 1.5),
    ]


def searched(squares=(1.0,) * 8):
    """A search for nothing that came to its end."""
    return Calibration(CAR, Found((), np.ones(0), np.ones(0), 0.0, 0.0, np.array(squares), 1, True))


def test_readings_that_do_not_fit_the_vehicle_are_doubted():
    assert doubt_of(searched(), ()) == ""
    for worst in (50.0, np.nan):
        assert "the readings of yaw_rate" in doubt_of(searched((1.0, 1.0, worst, 1.0, 1.0, 1.0, 1.0, 1.0)), ())


def test_remarks_show_what_the_limits_rest_on():
    designed = designed_on(np.random.default_rng(1).exponential(1.0, (200, 2 * COUNT)), 1000.0)
    result = " ".join(remarks_of(searched(), designed, 300.0, False, True))
    assert "first 300 s" in result
    assert "one false alarm is expected in 1 000 h" in result
    assert "if the tail continues as an exponential: only" in result
    assert "rules of the paper are not calibrated" in result


FRONT = "wheel_speed_front_left"
CAR_COUNT = len(hypotheses_of_cars()) - 1


@pytest.fixture(scope="module")
def car():
    return drawn(0, 88002)


@pytest.fixture(scope="module")
def drive(car):
    whole = driven(car, 4.0, 88002)
    return Recording({name: whole[name] for name in OF_CARS})


@pytest.fixture(autouse=True)
def short(monkeypatch):
    monkeypatch.setattr("tierod.monitors.condition.limits.LEAST_HOURS", 0.04)


def test_limits_are_found_written_and_read_by_the_monitor(car, drive, tmp_path):
    path = tmp_path / "mine.toml"
    values = [f"{name}={car.brochure[name]:g}" for name in ("mass", "wheelbase")]
    assert main(["new", str(path), "--class", "midsize", *values]) == 0
    begun = load(path)
    assert condition_monitor(begun).judge.decision.weighing.limits == rolling_limits()
    found = identify("thresholds", {"a": drive}, begun)
    assert not found.doubt
    found.write_vehicle(path)
    kept = load(path)
    own = limits_of(kept, hypotheses_of_cars())
    assert own.fast == pytest.approx(found.result.designed.limits.fast, rel=1e-4)
    assert condition_monitor(kept).judge.decision.weighing.limits == own
    assert own != rolling_limits()
    notes = CONDITION.variants["bank"].open(kept, 100.0, None)._car.notes
    assert "its own drives" in notes[0]


def test_no_limit_is_wider_than_those_of_any_car_unless_its_own_driving_comes_near():
    usual = rolling_limits()
    wide = usual.__class__((25.0,) * CAR_COUNT, (25.0,) * CAR_COUNT, usual.gap, usual.margin)
    quiet = np.full((4, 2 * CAR_COUNT), -1.0)
    limits, lowered = _no_wider(wide, quiet)
    assert (limits.fast, limits.slow, lowered) == (usual.fast, usual.slow, 2 * CAR_COUNT)
    rough = quiet.copy()
    rough[2, 0] = 20.0
    limits, lowered = _no_wider(wide, rough)
    assert (limits.fast[0], lowered) == (25.0, 2 * CAR_COUNT - 1)


@pytest.mark.parametrize("name", [FRONT, "yaw_rate"])
def test_a_drive_with_a_fault_is_named_and_nothing_may_be_used(car, drive, name):
    given = drive[name]
    wrong = (given.time > 100.0) & (given.time < 110.0)
    values = np.where(wrong, given.values + (2.0 if name == FRONT else 0.3), given.values)
    bad = drive.with_channels([Channel(name, given.time, values, given.unit)])
    assert f"b: {name}" in calibrate_motion({"a": drive.slice(stop=90.0), "b": bad}, car.brochure).doubt


def test_too_few_sensors_and_too_little_driving_are_refused(car, drive, monkeypatch):
    few = Recording({name: drive[name] for name in OF_CARS if not name.startswith("wheel_speed_rear")})
    few = few.slice(stop=100.0)
    assert len(few.names) == 4
    with pytest.raises(InputError, match="rear"):
        calibrate_motion({"a": few}, car.brochure)
    fewer = Recording({name: drive[name] for name in ("yaw_rate", FRONT, "wheel_speed_rear_left")})
    with pytest.raises(InputError, match="3 of the sensors.*it lacks.*steering_wheel_angle"):
        calibrate_motion({"a": fewer}, car.brochure)
    with pytest.raises(InputError, match="better an hour"):
        calibrate_motion({"a": drive.slice(stop=60.0)}, car.brochure)
