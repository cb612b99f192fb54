import numpy as np
import pytest

from monitors.motor_angle.monitored import columns
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.monitors.motor_angle.comparison import Increments, Stuck
from tierod.monitors.motor_angle.electrical import NotFollowing

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


@pytest.mark.parametrize("make", [lambda: Increments(window=0.0), lambda: Stuck(travel=-1.0)])
def test_tests_that_cannot_be_are_refused(make):
    with pytest.raises(ParameterError):
        make()
