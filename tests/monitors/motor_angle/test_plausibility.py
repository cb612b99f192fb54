import numpy as np
import pytest

from monitors.motor_angle.monitored import columns
from tierod.core.graph import scan
from tierod.monitors.motor_angle.plausibility import (
    MOTOR,
    PINION,
    WHEEL,
    AnglePlausibility,
    Superposition,
    VariableGain,
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


GAIN = VariableGain(1.5, 0.75, 20.0)
SPEED = 20.0 + 10.0 * np.sin(0.5 * TIME)
WANTED = 22.5 * (GAIN.superposition_gain_fast + 0.75 / (1.0 + (SPEED / 20.0) ** 2) - 1.0) * WHEEL_ANGLE
BELOW = WANTED / 22.5 + WHEEL_ANGLE - TORQUE / 140.0


def test_a_motor_that_follows_the_variable_ratio_makes_no_detour():
    found = judged(motor=WANTED, pinion=BELOW, speed=SPEED, gain=GAIN)
    assert found["alarm"].max() == 0.0
    assert np.abs(found["detour"]).max() < 0.01
