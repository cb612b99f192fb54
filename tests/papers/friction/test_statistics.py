import math

import numpy as np
import pytest

from tierod_lab.papers.friction.statistics import best_accuracy, on_right_side, overlap, plus_minus

LOW, HIGH = np.array([1.0, 2.0, 3.0, 4.0]), np.array([3.5, 5.0, 6.0, 7.0])


def test_overlap_is_nothing_apart_and_all_together():
    assert overlap(LOW, LOW + 100.0) == 0.0
    assert overlap(LOW, LOW) == pytest.approx(1.0)
    assert math.isnan(overlap(LOW, np.zeros(0)))


@pytest.mark.parametrize("shift", [0.5, 1.0, 2.0])
def test_overlap_of_normal_groups(shift):
    chance = np.random.default_rng(0)
    one, other = chance.standard_normal((2, 200_000))
    # Two normal densities a distance d apart share erfc(d / sqrt(8)).
    assert overlap(one, other + shift) == pytest.approx(math.erfc(shift / math.sqrt(8.0)), abs=0.01)


def test_overlap_on_a_logarithmic_scale_does_not_depend_on_the_unit():
    chance = np.random.default_rng(1)
    one, other = np.exp(chance.standard_normal((2, 5000)))
    whole = overlap(one, 3.0 * other, logarithmic=True)
    assert overlap(1e3 * one, 3e3 * other, logarithmic=True) == pytest.approx(whole, abs=0.01)


def test_accuracy_at_a_threshold_and_at_the_best_one():
    assert on_right_side(LOW, HIGH, 4.5) == pytest.approx(0.875)
    assert best_accuracy(LOW, HIGH) == pytest.approx(0.875)
    assert best_accuracy(LOW, LOW + 10.0) == 1.0
    # The wrong way round no threshold helps: half of all is the least.
    assert best_accuracy(LOW + 10.0, LOW) == 0.5


def test_figures_of_a_table():
    assert plus_minus(np.array([3.0, 5.0]), 4.5) == "-0.50 ± 1.00"
    assert plus_minus(np.array([3.0, 5.0])) == "4.00 ± 1.00"
    assert plus_minus(np.zeros(0)) == "none"
