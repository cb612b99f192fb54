import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.papers.column.analysis import HEARD, analyse_column, balanced_column, damping_ratio, vibrations
from tierod_lab.papers.column.parameter_sets import SETS


@pytest.fixture(scope="module")
def found():
    return analyse_column(SETS["S1"])


def test_modes_slowest_first(found):
    values = vibrations(found.system)
    np.testing.assert_allclose(np.abs(values), [0.0, 8.1149, 79.7504, 706.7509], atol=1e-3)
    assert damping_ratio(values[2]) == pytest.approx(0.0481496, abs=1e-6)
    assert math.isnan(damping_ratio(0j))


def test_every_reduction_keeps_both_torques_observable(found):
    for row in found.reductions:
        assert set(row.extended.ranks.values()) == {6}
        assert len(row.system.A) == 4


def test_the_series_spring_is_the_best_mechanical_one_and_the_balanced_column_better_still(found):
    worst = {row.name: row.errors[-1] for row in found.reductions}
    assert worst["balanced"] < 0.005
    assert worst["balanced"] < worst["mechanical, series"] < worst["mechanical, torsion bar"]
    assert worst["mechanical, series"] < worst["mechanical, printed"]
    assert all(len(row.errors) == len(HEARD) and list(row.errors) == sorted(row.errors) for row in found.reductions)


def test_the_bound_of_the_balanced_column_holds_where_it_is_reported(found):
    bounds = {row.name: row.reduction.error_bound for row in found.reductions if row.reduction}
    assert bounds["balanced"] > 0.0
    assert bounds["balanced, without D"] is None


@pytest.mark.parametrize("name", SETS)
def test_the_balanced_column_of_every_set(name):
    eigenvalues = np.sort_complex(np.linalg.eigvals(balanced_column(SETS[name]).system.A))
    expected = [-8.1149075, -3.8399224 - 79.6578986j, -3.8399224 + 79.6578986j, 0.0]
    np.testing.assert_allclose(eigenvalues, expected, atol=5e-4)


def test_a_repelling_gear_is_refused():
    with pytest.raises(ParameterError, match=r"the bench is unstable: eigenvalue .* in gear_"):
        analyse_column(replace(SETS["S1"], gear_stiffness=-7.0), "the bench")
