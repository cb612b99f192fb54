import numpy as np
import pytest

from tierod.methods.identification.normal_equations import solved

RANDOM = np.random.default_rng(3)
COLUMNS = RANDOM.normal(size=(400, 3))


def solution(columns, explained):
    return solved(columns.T @ columns, columns.T @ explained, float(explained @ explained), len(explained))


def test_parameters_and_their_deviations_come_out():
    explained = COLUMNS @ [2.0, -0.5, 0.1] + 0.05 * RANDOM.normal(size=400)
    found = solution(COLUMNS, explained)
    assert found.values == pytest.approx([2.0, -0.5, 0.1], abs=4.0 * found.deviations.max())
    assert found.deviations == pytest.approx(0.05 / 20.0, rel=0.2)
    assert found.left == pytest.approx(400 * 0.05**2, rel=0.2)


@pytest.mark.parametrize("third", [np.zeros(400), COLUMNS[:, 0] + 1e-7 * COLUMNS[:, 1]])
def test_regressors_that_are_zero_or_dependent_determine_nothing(third):
    assert solution(np.column_stack([COLUMNS[:, :2], third]), COLUMNS[:, 0]) is None
