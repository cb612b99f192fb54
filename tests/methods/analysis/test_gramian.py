import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm

from methods.analysis.column_sets import column
from tierod.core.errors import ParameterError
from tierod.methods.analysis.gramian import controllability_gramian, gramian_condition, observability_gramian
from tierod.models.linear import LinearSystem


@pytest.mark.parametrize("rate", [-2.0, 0.0, 3.0])
def test_one_state_in_closed_form(rate):
    system = LinearSystem.of([[rate]], [[5.0]], [[7.0]])
    over = math.expm1(2.0 * rate * 1.5) / (2.0 * rate) if rate else 1.5
    assert observability_gramian(system, 1.5)[0, 0] == pytest.approx(25.0 * over)
    assert controllability_gramian(system, 1.5)[0, 0] == pytest.approx(49.0 * over)


def test_over_a_time_it_is_the_integral():
    system = column()

    def integrand(t):
        seen = system.C @ expm(system.A * t)
        return seen.T @ seen

    integral = sum(quad_vec(integrand, k * 0.02, (k + 1) * 0.02, epsrel=1e-10)[0] for k in range(5))
    np.testing.assert_allclose(observability_gramian(system, 0.1), integral, rtol=1e-6, atol=1e-9 * integral.max())


def test_all_time_is_the_limit_of_a_stable_system():
    system = LinearSystem.of([[0.0, 1.0], [-4.0, -1.0]], [[1.0, 0.0]], [[0.0], [1.0]])
    np.testing.assert_allclose(observability_gramian(system), observability_gramian(system, 60.0), rtol=1e-9)
    np.testing.assert_allclose(controllability_gramian(system), controllability_gramian(system, 60.0), atol=1e-12)


def test_all_time_is_refused_where_something_does_not_decay():
    with pytest.raises(ParameterError, match="does not decay; give a horizon"):
        observability_gramian(column())
    with pytest.raises(ParameterError, match="horizon is 0"):
        observability_gramian(column(), 0.0)


def test_the_condition_does_not_depend_on_units():
    gramian = observability_gramian(column(), 1.0)
    unit = 10.0 ** np.arange(-3.0, 3.0)
    assert gramian_condition(gramian * np.outer(unit, unit)) == pytest.approx(gramian_condition(gramian), rel=1e-6)
    assert gramian_condition(np.diag([1.0, 1e-9])) == 1.0


def test_what_is_hidden_has_no_condition():
    blind = replace(column(), C=column().C[2:])
    assert gramian_condition(observability_gramian(blind, 1.0)) == math.inf
    assert gramian_condition(np.diag([1.0, 0.0])) == math.inf
