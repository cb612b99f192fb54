import numpy as np
import pytest

from monitors.motor_angle.motor_drives import drive, observed
from monitors.motor_angle.steady_motor import TIME, load_torque, steady
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.dq_motor import DqMotorParameters
from tierod_lab.papers.motor_angle.printed_observers import extended_kalman, luenberger, reduced_luenberger

P = load("motor-bench").parameters_for(DqMotorParameters)
MAKERS = [luenberger, reduced_luenberger, extended_kalman]


@pytest.mark.parametrize("make", MAKERS)
def test_with_the_load_as_a_state_speed_and_load_are_right(make):
    found = scan(make(P, TIME, axes="measured"), steady(60.0, 12.0))
    assert found["motor_speed"][-1] == pytest.approx(60.0, rel=0.005)
    assert found["motor_load_torque"][-1] == pytest.approx(load_torque(60.0, 12.0), rel=0.01)


@pytest.mark.parametrize(
    ("make", "per_load"), [(luenberger, -25.73), (reduced_luenberger, -27.78)], ids=["full", "reduced"]
)
def test_without_it_the_speed_is_wrong_in_proportion_to_the_load(make, per_load):
    errors = {}
    for current in (6.0, 12.0):
        found = scan(make(P, TIME, load=False, axes="measured"), steady(60.0, current))
        errors[current] = 60.0 - found["motor_speed"][-1]
    gained = load_torque(60.0, 12.0) - load_torque(60.0, 6.0)
    assert (errors[12.0] - errors[6.0]) / gained == pytest.approx(per_load, rel=0.005)


def test_the_printed_torque_constant_makes_it_wrong_otherwise():
    found = scan(luenberger(P, TIME, load=False, axes="measured", torque_constant="printed"), steady(0.0, 0.6 / 0.051))
    right = scan(luenberger(P, TIME, load=False, axes="measured"), steady(0.0, 0.6 / 0.051))
    assert found["motor_speed"][-1] / right["motor_speed"][-1] == pytest.approx(17.25 / 25.73, rel=0.01)


def test_the_filter_follows_a_drive_and_a_jump_of_the_sensor_enters_measured_axes_only():
    signals = drive(20)
    sensor = signals["sensor"].copy()
    sensor[100_000:] += 0.05
    turning = np.abs(signals["truth_speed"][100_000:]) > 20.0

    def change(axes):
        fault_free, wrong = (observed(extended_kalman(P, TIME, axes=axes), signals, each) for each in (None, sensor))
        return np.sqrt(np.mean((wrong["motor_speed"] - fault_free["motor_speed"])[100_000:][turning] ** 2))

    assert change("own") == 0.0
    assert change("measured") > 0.1


def test_the_swapped_jacobian_still_converges_and_is_worse():
    signals = drive(20)

    def rms(jacobian):
        found = observed(extended_kalman(P, TIME, axes="measured", jacobian=jacobian), signals)
        return np.sqrt(np.mean((found["motor_speed"] - signals["truth_speed"]) ** 2))

    right, printed = rms("corrected"), rms("printed")
    assert right < printed < 3.0 * right


def test_the_angle_begins_at_the_sensor_and_the_residual_is_electrical():
    samples = steady(50.0, 3.0, angle=2.0)
    samples[:30, 4] = np.nan
    samples[3000:, 4] += 0.05
    found = scan(luenberger(P, TIME), samples)
    assert found["motor_angle"][30] == pytest.approx(samples[30, 4])
    assert (found["angle_residual_electrical"][:30] == 0.0).all()
    step = found["angle_residual_electrical"][3000] - found["angle_residual_electrical"][2999]
    assert step == pytest.approx(4.0 * 0.05, abs=1e-3)


def test_missing_voltages_hold_the_speed():
    samples = steady(50.0, 3.0)
    samples[2000:2100, 2] = np.nan
    found = scan(luenberger(P, TIME, axes="measured"), samples)
    assert (found["motor_speed"][2000:2100] == found["motor_speed"][1999]).all()


def test_what_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="expected own or measured"):
        luenberger(P, TIME, axes="sensor")
    with pytest.raises(ParameterError, match=r"0\.2 at most"):
        extended_kalman(P, 1e-3)
    with pytest.raises(ParameterError, match="expected corrected or printed"):
        extended_kalman(P, TIME, jacobian="swapped")
