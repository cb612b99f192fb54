import numpy as np
import pytest

from tierod_lab.papers.condition import trends
from tierod_lab.papers.condition.drives import TARGETS, Drive, lost
from tierod_lab.papers.condition.recorded import recorded
from tierod_lab.papers.condition.truth import Declared, observable
from tierod_lab.papers.condition.vehicles import SHORT


def test_the_longest_run_is_found_at_either_end():
    assert trends.longest_run(np.array([1, 1, 0, 1, 1, 1], bool)) == (3, 3)
    assert trends.longest_run(np.array([1, 1, 0, 1], bool)) == (0, 2)
    assert trends.longest_run(np.zeros(4, bool)) == (0, 0)


def test_a_delay_counts_from_the_fault_and_candidates_count_apart():
    drive = Drive(SHORT, 6.0, 1, 0, (lost(trends.MOTOR, start=2.0, end=6.0),))
    time = np.arange(600) / 100.0
    declared = Declared(time, {trends.MOTOR: time > 3.495}, {trends.MOTOR: (time > 2.995) | (time < 1.0)})
    assert trends.delay(declared, drive) == pytest.approx((1.5, 1.0))
    assert trends.delay(Declared(time, {}), drive) == (np.inf, np.inf)


def test_the_motor_fails_where_for_longest_hardly_any_torque_is_asked_of_it(monkeypatch):
    monkeypatch.setattr(trends, "ACTUATOR_SECONDS", 60.0)
    monkeypatch.setattr(trends, "_FROM", 10.0)
    seconds, name, start = trends._quiet(SHORT)
    made = recorded(Drive(SHORT, 60.0, 1, trends._LATE))
    time, asked = made["yaw_rate"].time, made[TARGETS[trends.MOTOR]].values
    assert name == SHORT
    assert 10.0 <= start <= 40.0
    power = np.convolve(asked**2, np.full(10, 0.1), "full")[: len(asked)]
    stretch = (time >= start) & (time < start + seconds - 0.005)
    assert np.sqrt(power[stretch]).max() < 1.5  # three standard deviations of what all else knows
    drive = trends.quiet_drive((SHORT,))
    assert (drive.course, drive.injected[0].start) == (SHORT, start)
    assert observable(drive, recorded(drive))[1] >= 0.0
