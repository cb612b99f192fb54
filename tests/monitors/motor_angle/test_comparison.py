"""The sensor beside a made-up observer: the sum is the arithmetic of its drift, and only what counts is added."""

import math

import numpy as np
import pytest

from monitors.motor_angle.monitored import columns
from tierod.core.graph import scan
from tierod.monitors.motor_angle.comparison import (
    ANGLE_DRIFT,
    ANGLE_THRESHOLD,
    Increments,
    NotFollowing,
    ResidualGate,
    SensorComparison,
    Stuck,
)

STEP, POLES, FLUX, SPEED, SECONDS = 1e-3, 4.0, 0.0085, 30.0, 8.0
BLOCK = SensorComparison(ResidualGate(POLES, FLUX, STEP), Increments(STEP))


def samples(offset=0.0, gain=1.0, speed=SPEED):
    """A motor that turns steadily and is known well; the sensor is wrong from 6 s on, by an electrical offset."""
    time = np.arange(round(SECONDS / STEP)) * STEP
    angle = speed * time
    wrong = np.where(time > 6.0, offset / POLES + (gain - 1.0) * speed * (time - 6.0), 0.0)
    return columns(
        BLOCK,
        len(time),
        angle_residual_electrical=POLES * wrong,
        motor_angle_mechanical=angle + wrong,
        motor_speed=speed,
        motor_angle_standard_deviation=0.001,
        motor_flux=FLUX,
        standing=0.0,
        motor_angle=angle,
    )


def first(found, name):
    return int(np.argmax(found[name] > 0.5)) * STEP if found[name].max() > 0.5 else math.inf


def test_a_sensor_that_agrees_counts_and_raises_nothing():
    found = scan(BLOCK, samples())
    assert found["early"][4900] == 1.0
    assert found["early"][5100] == 0.0
    assert found["known"][-1] == 1.0
    assert found["angle_sum"].max() == 0.0
    assert not any(found[f"{name}_alarm"].max() for name in ("angle", "speed", "backwards", "stuck"))


@pytest.mark.parametrize("offset", [0.1, -0.1, 0.3])
def test_the_sum_grows_by_the_offset_less_its_drift(offset):
    found = scan(BLOCK, samples(offset))
    steps = ANGLE_THRESHOLD / (abs(offset) - ANGLE_DRIFT)
    assert first(found, "angle_alarm") == pytest.approx(6.0 + steps * 1e-3, abs=0.004)


def test_a_motor_that_is_slow_counts_for_nothing():
    found = scan(BLOCK, samples(0.3, speed=5.0))
    assert found["counts"].max() == 0.0
    assert found["angle_sum"].max() == 0.0


def test_a_gain_shows_in_what_both_gain():
    found = scan(BLOCK, samples(gain=1.1))
    assert found["speed_residual"].max() == pytest.approx(0.1 * SPEED, rel=0.02)
    assert first(found, "speed_alarm") < 6.1


def test_a_sensor_that_stands_and_one_that_turns_back_are_reported():
    assert first(scan(BLOCK, samples(gain=0.0)), "stuck_alarm") < 6.1
    assert 6.02 < first(scan(BLOCK, samples(gain=-1.0)), "backwards_alarm") < 6.1


GATE = ResidualGate(4.0, 0.0085, start=0.1)


def counted(speed=20.0, deviation=0.005, flux=0.0085, standing=0.0, angle=1.0, samples=3000):
    seen = {
        "motor_angle_mechanical": angle,
        "motor_speed": speed,
        "motor_angle_standard_deviation": deviation,
        "motor_flux": flux,
        "standing": standing,
    }
    return scan(GATE, columns(GATE, samples, **seen))


def test_it_counts_one_value_in_a_millisecond_after_start_and_hold():
    found = counted()
    first = int(np.argmax(found["counts"]))
    assert first in range(1190, 1202)
    assert found["counts"].sum() == pytest.approx((3000 - first) / 10, abs=1)


@pytest.mark.parametrize(
    "away", [{"speed": 9.9}, {"deviation": 0.04}, {"flux": 0.006}, {"standing": 1.0}, {"angle": np.nan}]
)
def test_nothing_counts_where_the_currents_show_no_angle(away):
    assert counted(**away)["counts"].sum() == 0.0


def test_an_interruption_begins_the_hold_anew():
    speed = np.full(3000, -20.0)
    speed[2000] = 0.0
    known = counted(speed=speed)["known"]
    assert known[1999] == 1.0
    assert known[2000:2190].max() == 0.0
    assert known[2210:].min() == 1.0


def test_readings_in_every_tenth_sample_count_all():
    angle = np.where(np.arange(3000) % 10 == 3, 1.0, np.nan)
    assert counted(angle=angle)["counts"].sum() == pytest.approx(180, abs=1)


TIME = np.arange(4000) / 1e4


def turning(sensor, observer, standing=0.0):
    seen = {"motor_angle_mechanical": sensor, "motor_angle": observer, "standing": standing}
    return columns(Increments(), len(TIME), **seen)


def following(target, sensor):
    block = NotFollowing()
    seen = columns(block, len(TIME), target_motor_angle_mechanical=target, motor_angle_mechanical=sensor)
    return scan(block, seen)["alarm"]


def sparse(angle):
    return np.where(np.arange(len(TIME)) % 10 == 0, angle, np.nan)


@pytest.mark.parametrize("sensor", [lambda angle: angle, sparse])
def test_gains_over_windows_show_the_scale(sensor):
    angle = 50.0 * TIME
    found = scan(Increments(), turning(sensor(1.02 * angle), angle))
    complete = found["complete"] > 0.5
    assert complete.sum() >= 38
    np.testing.assert_allclose(found["sensor"][complete] / found["observer"][complete], 1.02, rtol=1e-9)


def test_a_sensor_that_begins_anew_every_turn_gains_the_same():
    angle = 50.0 * TIME
    found = scan(Increments(), turning(angle % (2.0 * np.pi), angle))
    complete = found["complete"] > 0.5
    np.testing.assert_allclose(found["sensor"][complete], found["observer"][complete], atol=1e-9)


def test_standing_and_slow_windows_show_nothing():
    assert scan(Increments(), turning(50.0 * TIME, 50.0 * TIME, 1.0))["complete"].sum() == 0.0
    assert scan(Increments(), turning(5.0 * TIME, 5.0 * TIME))["complete"].sum() == 0.0


@pytest.mark.parametrize("sensor", [lambda angle: angle, sparse])
def test_a_stuck_sensor_is_found_once_the_motor_has_turned(sensor):
    angle = 50.0 * TIME
    stuck = np.minimum(angle, 10.0)
    found = scan(Stuck(), turning(sensor(stuck), angle))["alarm"]
    assert found[:2000].max() == 0.0
    assert np.argmax(found) / 1e4 == pytest.approx(0.2 + 0.15 / 50.0, abs=0.0012)
    assert scan(Stuck(), turning(sensor(angle), angle))["alarm"].max() == 0.0
    assert scan(Stuck(), turning(sensor(stuck), angle, 1.0))["alarm"].max() == 0.0


def test_a_drive_that_stays_away_from_its_target_is_found():
    target = 20.0 * TIME
    sensor = np.where(TIME < 0.2, target, 4.0)
    found = following(target, sensor)
    assert np.argmax(found) / 1e4 == pytest.approx(0.2 + 1.0 / 20.0 + 0.02, abs=0.002)
    assert following(target, target - 0.3).max() == 0.0


def test_a_target_that_never_moves_or_is_missing_shows_nothing():
    for target in (np.zeros(len(TIME)), np.full(len(TIME), np.nan)):
        assert following(target, 20.0 * TIME).max() == 0.0
