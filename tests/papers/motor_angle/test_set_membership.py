"""Against corners of a polytope worked out by hand and by brute force over its vertices."""

from itertools import combinations

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod_lab.papers.motor_angle.set_membership import Bounded, feasible_box


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
