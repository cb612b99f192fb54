import pytest

from tierod.vehicles import load
from tierod_lab.papers.motor_angle.dq_motor import DqMotorParameters
from tierod_lab.papers.motor_angle.load_bias import predicted, settled, slope, standing, stepped
from tierod_lab.papers.motor_angle.printed_observers import luenberger

P = load("motor-bench").parameters_for(DqMotorParameters)


def test_the_bench_shows_the_error_that_the_gains_promise():
    seen = stepped(11)
    observer = luenberger(P, 1e-4, load=False, axes="measured")
    assert slope(observer, [seen]) == pytest.approx(predicted()["full"], rel=0.02)
    loads, errors = settled(observer, seen)
    assert len(loads) == 7
    assert loads[-1] - loads[0] == pytest.approx(1.2, abs=0.01)
    assert errors[0] > 0.0 > errors[-1]


def test_held_still_with_a_warm_winding_the_observer_shows_a_speed_that_is_not_there():
    measured, computed = standing()
    assert computed == pytest.approx(0.05 / 6.0 * 0.6 / 0.051 / 0.034)
    assert measured == pytest.approx(computed, rel=0.05)
