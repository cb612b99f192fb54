from itertools import combinations

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.methods.identification.motor_recording import MotorRecording
from tierod_lab.papers.motor_angle.guaranteed_intervals import Bounded, MotorErrorBounds, feasible_box, guaranteed_motor


def exact(regressors, values, bound):
    regressors, values = np.array(regressors, float), np.array(values, float)
    return Bounded(regressors, values, np.full(len(values), bound), np.zeros_like(regressors))


def test_a_diamond_has_the_box_of_its_corners():
    # |3 - (a + b)| <= 0.5 and |1 - (a - b)| <= 0.5: corners (2.5, 1), (1.5, 1), (2, 1.5), (2, 0.5)
    box = feasible_box(exact([[1, 1], [1, -1]], [3, 1], 0.5))
    assert box.low == pytest.approx([1.5, 0.5])
    assert box.high == pytest.approx([2.5, 1.5])
    assert box.middle == pytest.approx([2.0, 1.0])
    assert box.half_width == pytest.approx([0.5, 0.5])


def test_an_error_of_a_regressor_widens_in_proportion_to_the_parameter():
    # |10 - 2 a| <= 0.1 a: a from 10 / 2.1 to 10 / 1.9
    rows = Bounded(np.array([[2.0]]), np.array([10.0]), np.zeros(1), np.array([[0.1]]))
    assert feasible_box(rows).low == pytest.approx([10.0 / 2.1])
    assert feasible_box(rows).high == pytest.approx([10.0 / 1.9])


def test_the_box_is_that_of_all_vertices_and_holds_the_truth():
    random = np.random.default_rng(7)
    true = np.array([0.7, 2.0])
    regressors = random.normal(size=(12, 2))
    values = regressors @ true + random.uniform(-0.1, 0.1, 12)
    rows = exact(regressors, values, 0.1)
    pairs = list(zip(regressors, values, strict=True))
    planes = [(sign * row, sign * value + 0.1) for row, value in pairs for sign in (1, -1)]
    corners = []
    for (a, p), (b, q) in combinations(planes, 2):
        if abs(np.linalg.det([a, b])) > 1e-9:
            corner = np.linalg.solve([a, b], [p, q])
            if all(row @ corner <= right + 1e-9 for row, right in planes):
                corners.append(corner)
    box = feasible_box(rows)
    assert box.low == pytest.approx(np.min(corners, axis=0))
    assert box.high == pytest.approx(np.max(corners, axis=0))
    assert (box.low <= true).all()
    assert (true <= box.high).all()


def test_contradictions_and_free_directions_are_said():
    with pytest.raises(InputError, match="no parameters agree"):
        feasible_box(exact([[1.0], [1.0]], [1.0, 2.0], 0.3))
    with pytest.raises(InputError, match="parameter 2 of 2 is not bounded"):
        feasible_box(exact([[1.0, 0.0]], [1.0], 0.3))
    with pytest.raises(ParameterError, match="below zero"):
        feasible_box(exact([[1.0]], [1.0], -0.3))
    with pytest.raises(ParameterError, match="do not match"):
        feasible_box(Bounded(np.ones((2, 1)), np.ones(3), np.ones(3), np.ones((2, 1))))


R, L, PSI, PAIRS, STEP = 0.05, 1e-4, 0.0085, 4.0, 1e-4
BOUNDS = MotorErrorBounds(0.26, 0.05, 8.7e-4, 2e6)


def seen(errors=1.0, resistance=R, seed=1):
    time = STEP * np.arange(20000)
    angle = 3.0 * np.sin(20.0 * time)
    rates, sizes = np.array([40.0, -700.0, 11.0]), np.array([12.0, 6.0 - 2.0j, 15.0j])
    current = np.sum(sizes * np.exp(1j * np.outer(time, rates)), axis=1)
    charge = np.sum(sizes / (1j * rates) * np.exp(1j * np.outer(time, rates)), axis=1)
    flux = L * current + PSI * np.exp(1j * PAIRS * angle)
    voltage = np.concatenate([[0.0], np.diff(resistance * charge + flux) / STEP])
    random = np.random.default_rng(seed)

    def noise(bound):
        return errors * bound * random.uniform(-1.0, 1.0, len(time))

    return MotorRecording(
        "drive",
        STEP,
        time,
        current + noise(0.26) + 1j * noise(0.26),
        voltage + noise(0.05) + 1j * noise(0.05),
        angle + noise(8.7e-4),
    )


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_the_truth_lies_within_and_the_box_is_narrow(seed):
    box = guaranteed_motor([seen(seed=seed)], PAIRS, BOUNDS)
    true = np.array([R, L, PSI])
    assert (box.low <= true).all()
    assert (true <= box.high).all()
    assert (box.half_width / true < [0.1, 0.5, 0.05]).all()


def test_more_windows_make_it_no_wider():
    every, some = (guaranteed_motor([seen()], PAIRS, BOUNDS, lengths) for lengths in ((16, 64), (16,)))
    assert (every.low >= some.low - 1e-9).all()
    assert (every.high <= some.high + 1e-9).all()
    assert (every.half_width < some.half_width).any()


def test_bounds_that_are_too_small_leave_nothing():
    tight = MotorErrorBounds(0.02, 0.004, 1e-5, 2e6)
    with pytest.raises(InputError, match="a bound is too small"):
        guaranteed_motor([seen()], PAIRS, tight)
    with pytest.raises(InputError, match="a bound is too small"):
        guaranteed_motor([seen(), seen(resistance=2.0 * R)], PAIRS, BOUNDS)


def test_a_gap_costs_its_windows_only_and_no_window_is_said():
    broken = seen()
    broken.current[5000:6000] = np.nan
    assert guaranteed_motor([broken], PAIRS, BOUNDS).low[0] > 0.0
    broken.current[::3] = np.nan
    with pytest.raises(InputError, match="no window"):
        guaranteed_motor([broken], PAIRS, BOUNDS)
