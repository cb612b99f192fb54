import math

import numpy as np
import pytest

from tierod.errors import ParameterError
from tierod.proving_ground.cars.column_bench import ColumnBench
from tierod.proving_ground.cars.motor_bench import MotorBench
from tierod.proving_ground.courses.bench import BenchSweep
from tierod.proving_ground.run import run


def frequency(sweep, at):
    """By counting upward crossings of zero around an instant [Hz]."""
    time = np.arange(at - 0.5, at + 0.5, 1e-4)
    torque = sweep.columns(time, 0.0 * time, 0.0, 0.0)["motor_torque"]
    up = time[1:][(torque[:-1] < 0.0) & (torque[1:] >= 0.0)]
    return (len(up) - 1) / (up[-1] - up[0])


def test_the_sweep_passes_its_frequencies_at_an_even_pace_of_octaves():
    sweep = BenchSweep(amplitude=0.5, lowest=4.0, highest=32.0, settle=1.0, time=31.0)
    assert [frequency(sweep, at) for at in (11.0, 21.0)] == pytest.approx([8.0, 16.0], rel=0.03)
    time = np.linspace(0.0, 31.0, 5000)
    torque = sweep.columns(time, time, 0.0, 0.0)["motor_torque"]
    assert np.all(torque[time < 1.0] == 0.0)
    assert np.max(np.abs(torque)) == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize(("wheel", "locked", "grip"), [("free", 0.0, 0.0), ("locked", 1.0, 0.0), ("held", 0.0, 1.0)])
def test_the_wheel_is_what_is_said(wheel, locked, grip):
    columns = BenchSweep(wheel=wheel).columns(np.zeros(1), np.zeros(1), 0.0, 0.0)
    assert (columns["locked"][0], columns.get("grip", [0.0])[0]) == (locked, grip)


def test_a_motor_alone_can_be_swept():
    outcome = run(MotorBench(), BenchSweep(amplitude=0.1, lowest=1.0), 3.0)
    assert outcome.diverged_at is None
    constant = 1.5 * 4 * 0.0085  # 3/2 times pole pairs times flux: torque per ampere along the axis beta at angle 0
    assert np.max(outcome.recording["truth_motor_current_beta"].values) == pytest.approx(0.1 / constant, rel=0.02)


def test_a_locked_wheel_stays_while_the_motor_turns():
    outcome = run(ColumnBench(), BenchSweep(wheel="locked"), 5.0)
    assert outcome.diverged_at is None
    assert np.max(np.abs(outcome.recording["truth_steering_wheel_angle"].values)) < 1e-9
    assert np.max(np.abs(outcome.recording["truth_motor_angle_mechanical"].values)) > 1e-3


@pytest.mark.parametrize(
    ("wrong", "words"), [({"lowest": 40.0}, "has no band"), ({"time": 0.5, "settle": 1.0}, "before it has settled")]
)
def test_a_sweep_that_cannot_be(wrong, words):
    with pytest.raises(ParameterError, match=words):
        BenchSweep(**wrong)


def test_a_constant_load_on_the_gear():
    columns = BenchSweep(gear_torque=-2.0).columns(np.zeros(2), np.zeros(2), 0.0, 0.0)
    assert columns["gear_torque"].tolist() == [-2.0, -2.0]
    assert math.isclose(BenchSweep().duration, 61.0)
