import numpy as np
import pytest

from monitors.motor_angle.monitored import columns
from tierod.core.errors import TierodError
from tierod.core.graph import scan
from tierod.monitors.motor_angle.plausibility import (
    MOTOR,
    NONE,
    NOT_MOTOR,
    PINION,
    WHEEL,
    AnglePlausibility,
    Superposition,
    VariableGain,
    WhichAngle,
)

TIME = np.arange(60_000) / 1e4
TORQUE = 4.0 * np.sin(3.0 * TIME)
WHEEL_ANGLE = 1.2 * np.sin(2.0 * TIME)
MOTOR_ANGLE = 9.0 * np.sin(2.5 * TIME + 0.3)
PINION_ANGLE = MOTOR_ANGLE / 22.5 + WHEEL_ANGLE - TORQUE / 140.0
LATE = TIME > 3.0


def judged(motor=MOTOR_ANGLE, wheel=WHEEL_ANGLE, pinion=PINION_ANGLE, torque=TORQUE, speed=None, gain=None):
    """Sampled as in a car: the motor's angle every millisecond, the others every ten with their resolution."""
    block = AnglePlausibility(Superposition(22.5, 1.0, 140.0), gain=gain)
    signals = {
        "motor_angle_mechanical": np.where(np.arange(len(TIME)) % 10 == 0, motor, np.nan),
        "steering_wheel_angle": np.where(np.arange(len(TIME)) % 100 == 0, np.round(wheel, 3), np.nan),
        "pinion_angle": np.where(np.arange(len(TIME)) % 100 == 0, pinion, np.nan),
        "driver_torque": np.where(np.arange(len(TIME)) % 100 == 0, torque, np.nan),
    }
    if speed is not None:
        signals["vehicle_speed"] = np.where(np.arange(len(TIME)) % 200 == 0, speed, np.nan)
    return scan(block, columns(block, len(TIME), **signals))


def test_angles_that_fit_pass_with_any_zero_and_wrapped():
    assert judged()["alarm"].max() == 0.0
    assert judged(motor=(MOTOR_ANGLE + 100.0) % (2.0 * np.pi), pinion=PINION_ANGLE - 0.3)["alarm"].max() == 0.0


def test_without_the_twist_of_the_bar_they_would_not_fit():
    assert judged(torque=np.zeros(len(TIME)))["alarm"].max() == 1.0


@pytest.mark.parametrize(
    ("name", "angle", "code"),
    [("motor", MOTOR_ANGLE, MOTOR), ("wheel", WHEEL_ANGLE, WHEEL), ("pinion", PINION_ANGLE, PINION)],
)
@pytest.mark.parametrize("kind", ["stuck", "jump"])
def test_the_wrong_one_is_named(name, angle, code, kind):
    size = 1.5 if name == "motor" else 0.1
    wrong = np.where(LATE, angle[30_000], angle) if kind == "stuck" else angle + size * LATE
    found = judged(**{name: wrong})
    first = int(np.argmax(found["alarm"]))
    assert 3.0 < TIME[first] < 3.5
    assert found["by_motion"][first] == code


def test_where_none_stands_out_none_is_named():
    found = judged(wheel=WHEEL_ANGLE + 0.05 * np.maximum(TIME - 3.0, 0.0))
    assert found["alarm"].max() == 1.0
    assert found["by_motion"][int(np.argmax(found["alarm"]))] == NONE


def test_angles_that_do_not_come_are_not_compared():
    assert judged(motor=np.where(LATE, np.nan, MOTOR_ANGLE))["alarm"].max() == 0.0
    assert judged(pinion=np.full(len(TIME), np.nan))["alarm"].max() == 0.0


GAIN = VariableGain(1.5, 0.75, 20.0)
SPEED = 20.0 + 10.0 * np.sin(0.5 * TIME)
WANTED = 22.5 * (GAIN.superposition_gain_fast + 0.75 / (1.0 + (SPEED / 20.0) ** 2) - 1.0) * WHEEL_ANGLE
BELOW = WANTED / 22.5 + WHEEL_ANGLE - TORQUE / 140.0


def test_a_motor_that_follows_the_variable_ratio_makes_no_detour():
    found = judged(motor=WANTED, pinion=BELOW, speed=SPEED, gain=GAIN)
    assert found["alarm"].max() == 0.0
    assert np.abs(found["detour"]).max() < 0.01


def test_a_recorded_wheel_that_is_wrong_makes_one_and_without_speed_there_is_none():
    wrong = WHEEL_ANGLE + 0.2 * np.maximum(TIME - 3.0, 0.0)
    found = judged(motor=WANTED, pinion=BELOW, wheel=wrong, speed=SPEED, gain=GAIN)
    assert np.abs(found["detour"]).max() > 0.05
    assert np.abs(judged(motor=WANTED, pinion=BELOW, wheel=wrong, gain=GAIN)["detour"]).max() == 0.0


COUNT, BEGIN = 4000, 1000
AFTER = np.arange(COUNT) >= BEGIN


def result(residual, suspect=NONE, detour=0.0, counts=10, mismatch=0.03):
    """Suspect over time where the angles disagree from `BEGIN` on, and the alarm comes 500 samples later."""
    columns = (
        np.where(AFTER, mismatch, 0.0),
        np.arange(COUNT) >= BEGIN + 500,
        np.where(np.arange(COUNT) >= BEGIN + 500, suspect, NONE),
        np.where(AFTER, detour, 0.0),
        np.where(AFTER, residual, 0.005),
        np.arange(COUNT) % counts == 0 if counts else np.zeros(COUNT),
    )
    return scan(WhichAngle(), np.column_stack(columns).astype(float))["suspect"]


def test_nothing_is_suspected_before_the_alarm():
    assert result(0.5)[: BEGIN + 499].max() == NONE


@pytest.mark.parametrize("suspect", [NONE, WHEEL, PINION])
def test_the_observer_against_the_sensor_makes_it_the_motor(suspect):
    assert result(0.5, suspect)[-1] == MOTOR


@pytest.mark.parametrize(("suspect", "said"), [(NONE, NOT_MOTOR), (MOTOR, NOT_MOTOR), (WHEEL, WHEEL), (PINION, PINION)])
def test_the_observer_by_the_sensor_makes_it_another(suspect, said):
    assert result(0.01, suspect)[-1] == said


def test_a_motor_that_goes_its_own_way_beside_a_wheel_that_does_not_makes_it_the_wheel():
    assert result(0.01, detour=0.06)[-1] == WHEEL


@pytest.mark.parametrize("suspect", [NONE, MOTOR, PINION])
def test_without_turning_motion_alone_decides(suspect):
    assert result(0.5, suspect, counts=0)[-1] == suspect


def test_what_the_observer_said_before_the_disagreement_does_not_count():
    assert result(0.5)[BEGIN + 700] == MOTOR


def test_numbers_that_cannot_be_are_refused():
    with pytest.raises(TierodError, match="agreement"):
        WhichAngle(agreement=0.0)
