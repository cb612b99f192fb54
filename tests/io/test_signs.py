"""Signals of the wrong sign, or of a wrong unit, beside the others."""

import dataclasses

import numpy as np
import pytest

import exact_vehicle
from shared_data import shared_data
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.io.readers import read
from tierod.io.signs import COMPARED, NAMES, sign_warnings, turn_warnings
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load
from tierod_lab import ground

RANDOM = np.random.default_rng(4)
TIME = np.arange(0.0, 60.0, 0.01)


def turns(name: str, scale: float, noise: float = 0.0) -> Channel:
    shape = np.sin(0.7 * TIME) + 0.5 * np.sin(1.9 * TIME)
    return Channel(name, TIME, scale * shape + noise * RANDOM.normal(size=len(TIME)), SIGNALS[name].unit)


def drive(**signs: float) -> Recording:
    scales = {
        "steering_wheel_angle": 0.8,
        "yaw_rate": 0.2,
        "lateral_acceleration": 3.0,
        "driver_torque": 2.0,
        "motor_torque": 1.5,
    }
    channels = [turns(name, signs.get(name, 1.0) * scale, 0.1 * scale) for name, scale in scales.items()]
    channels.append(Channel("vehicle_speed", TIME, np.full(len(TIME), 15.0), "m/s"))
    return Recording({channel.name: channel for channel in channels})


def test_right_signs_earn_no_warning():
    assert sign_warnings(drive()) == ()


@pytest.mark.parametrize("wrong", ["steering_wheel_angle", "yaw_rate", "lateral_acceleration"])
def test_the_odd_one_is_named(wrong):
    (warning,) = sign_warnings(drive(**{wrong: -1.0}))
    assert warning.startswith(f"{wrong} probably has the wrong sign (in turns")


def test_torques_against_each_other():
    (warning,) = sign_warnings(drive(motor_torque=-1.0))
    assert warning.startswith("driver_torque or motor_torque probably has the wrong sign")
    assert "correlation driver_torque with motor_torque -1.00" in warning


def test_a_speed_of_the_wrong_sign_blames_nothing_else():
    backwards = Channel("vehicle_speed", TIME, np.full(len(TIME), -15.0), "m/s")
    (warning,) = sign_warnings(drive().with_channels([backwards]))
    assert warning.startswith("vehicle_speed is negative for 100 % of the driving time")


def test_a_rate_against_its_angle():
    whole, rate = drive(), 0.8 * (0.7 * np.cos(0.7 * TIME) + 0.95 * np.cos(1.9 * TIME))
    for sign, count in ((1.0, 0), (-1.0, 1)):
        channel = Channel("steering_wheel_rate", TIME, sign * rate, "rad/s")
        warnings = sign_warnings(whole.with_channels([channel]))
        assert len(warnings) == count
        assert all("steering_wheel_angle or steering_wheel_rate probably has" in warning for warning in warnings)


def test_two_signals_are_both_named():
    whole = drive(yaw_rate=-1.0)
    pair = Recording({name: whole[name] for name in ("yaw_rate", "lateral_acceleration")})
    (warning,) = sign_warnings(pair)
    assert warning.startswith("yaw_rate or lateral_acceleration probably has the wrong sign")


@pytest.mark.parametrize(("first", "warned"), [(1.0, False), (-1.0, True)])
def test_the_first_hour_decides_however_long_the_recording_is(first, warned):
    time = np.arange(0.0, 4.0 * COMPARED, 0.1)
    shape = np.sin(0.7 * time) + 0.5 * np.sin(1.9 * time)
    sign = np.where(time < COMPARED, first, -first)
    channels = (
        Channel("yaw_rate", time, 0.2 * sign * shape, "rad/s"),
        Channel("lateral_acceleration", time, 3.0 * shape, "m/s**2"),
        Channel("odometer", np.array([0.0, 1e9]), np.zeros(2), "m"),
    )
    assert bool(sign_warnings(Recording({channel.name: channel for channel in channels}))) is warned


def test_straight_driving_says_nothing():
    noise = {name: turns(name, 0.0, 0.001) for name in ("yaw_rate", "lateral_acceleration")}
    assert sign_warnings(Recording(noise)) == ()
    assert sign_warnings(Recording({})) == ()


def parking(speed, angle, unsigned=True):
    """Motion sensors of a car that rolls without slip at a speed and a road wheel angle over `TIME`."""
    yaw = speed * np.tan(angle) / 2.6
    read = np.abs if unsigned else np.asarray
    signals = {
        "steering_wheel_angle": 16.0 * angle,
        "yaw_rate": yaw,
        "lateral_acceleration": speed * yaw,
        "wheel_speed_rear_left": read(speed - 0.75 * yaw),
        "wheel_speed_rear_right": read(speed + 0.75 * yaw),
        "vehicle_speed": read(speed),
    }
    noise = {"yaw_rate": 0.003, "lateral_acceleration": 0.05}
    return Recording({
        name: Channel(name, TIME, values + noise.get(name, 0.0) * RANDOM.normal(size=len(TIME)), SIGNALS[name].unit)
        for name, values in signals.items()
    })  # fmt: skip


BACK = 2.5 * np.interp(TIME, [0, 2, 4, 24, 26, 60], [0, 0, -1, -1, 0, 0])
BACK_AND_OUT = BACK + 2.2 * np.interp(TIME, [48, 50, 57, 59], [0, 1, 1, 0])
STEER = 0.4 * np.sin(0.5 * TIME)


def test_parking_with_reversing_is_no_wrong_sign():
    assert sign_warnings(parking(BACK_AND_OUT, STEER)) == ()


def test_reversing_with_signed_speeds_is_no_wrong_sign():
    longer = BACK + 2.4 * np.interp(TIME, [28, 30, 57, 59], [0, 1, 1, 0])
    assert sign_warnings(parking(longer, STEER, unsigned=False)) == ()


def test_reversing_alone_leaves_the_sign_open():
    (warning,) = sign_warnings(parking(BACK, STEER))
    assert warning.startswith("every turn mirrors the steering angle: the car reversed all the time, or the yaw rate")
    assert "record turns forward as well" in warning
    finding = diagnose(parking(BACK, STEER), load("midsize-eps"), "sideslip").findings[0]
    assert finding.cause in warning
    assert not [each for each in finding.warnings if "revers" in each], "said once, and not as a fact"


def test_a_negative_speed_at_walking_pace_may_be_reversing():
    (warning,) = sign_warnings(parking(BACK, STEER, unsigned=False))
    assert warning == (
        "vehicle_speed is negative for 100 % of the driving time: the car reversed, or the speed has the wrong sign; "
        "if the car drove forward, set the sign of vehicle_speed in the channel map"
    )


@pytest.mark.parametrize("wrong", ["yaw_rate", "steering_wheel_angle"])
def test_a_drive_with_parking_names_the_wrong_sign_as_before(wrong):
    whole = parking(BACK + 15.0 * np.interp(TIME, [30, 36, 58, 60], [0, 1, 1, 0]), STEER * np.where(TIME > 28, 0.1, 1))
    turned = whole[wrong]
    (warning,) = sign_warnings(whole.with_channels([Channel(wrong, TIME, -turned.values, turned.unit)]))
    assert warning.startswith(f"{wrong} probably has the wrong sign")


@pytest.fixture(scope="module")
def fault_free():
    return ground.drive(minutes=4.0, seed=2)


def scaled(recording: Recording, name: str, factor: float) -> Recording:
    return recording.with_channels([dataclasses.replace(recording[name], values=factor * recording[name].values)])


@pytest.mark.parametrize("factor", [1.0, -1.0, 0.8, 1.25])
@pytest.mark.parametrize("name", NAMES)
def test_signs_and_gains_are_no_matter_of_units(fault_free, name, factor):
    assert turn_warnings(scaled(fault_free, name, factor)) == ()


@pytest.mark.parametrize(
    ("name", "factor", "sentence"),
    [
        ("vehicle_speed", 3.6, "vehicle_speed looks like km/h taken for m/s"),
        ("vehicle_speed", 1.0 / 3.6, "vehicle_speed looks converted twice"),
        ("yaw_rate", 57.3, "at least one of them has a wrong unit"),
        ("lateral_acceleration", 1.0 / 9.81, "at least one of them has a wrong unit"),
    ],
)
def test_a_wrong_unit_is_reported(fault_free, name, factor, sentence):
    (warning,) = turn_warnings(scaled(fault_free, name, factor))
    assert sentence in warning


def test_a_wrong_unit_stands_beside_the_verdict(fault_free):
    finding = exact_vehicle.diagnose(scaled(fault_free, "vehicle_speed", 3.6), "midsize-eps").findings[0]
    assert [warning for warning in finding.warnings if "km/h taken for m/s" in warning]


def test_where_nothing_turns_or_is_known_nothing_is_said(fault_free):
    straight = {
        name: dataclasses.replace(fault_free[name], values=0.01 * fault_free[name].values) for name in NAMES[1:]
    }
    assert turn_warnings(fault_free.with_channels(straight.values())) == ()
    assert turn_warnings(fault_free.slice(0.0, 5.0)) == ()
    assert turn_warnings(fault_free.slice(0.0, 0.5)) == ()
    assert turn_warnings(Recording({"yaw_rate": fault_free["yaw_rate"]})) == ()
    rng = np.random.default_rng(1)
    noise = fault_free["yaw_rate"]
    unrelated = Channel("yaw_rate", noise.time, rng.normal(0.0, 10.0, len(noise.time)), "rad/s")
    assert turn_warnings(fault_free.with_channels([unrelated])) == ()


def test_a_car_with_unknown_units():
    recording = read(shared_data("revsted_slip_angle", "obd.csv"))
    (warning,) = turn_warnings(recording)
    ratio = float(warning.split("is ")[1].split(" times")[0])
    assert ratio == pytest.approx(np.pi / 180.0 / 3.6, rel=0.2), "degrees and km/h, taken for rad and m/s"
