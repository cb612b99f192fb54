import numpy as np
import pytest

from methods.analysis.column_sets import TORQUES, column
from tierod.methods.analysis.extended import extended
from tierod.methods.analysis.observability import observability
from tierod.methods.analysis.observability_matrix import default_rank, observability_matrix, scaled_rank, unscaled_rank
from tierod.methods.analysis.pbh import pbh_rank
from tierod.models.disturbances import with_outputs
from tierod.models.linear import LinearSystem, sampled
from tierod.papers.column.parameter_sets import EIGENVALUES, SETS

WHEEL, MOTOR, BAR = "steering_wheel_angle", "motor_angle_mechanical", "driver_torque"


@pytest.mark.parametrize("name", SETS)
def test_eigenvalues_are_those_of_the_table(name):
    found = np.sort_complex(np.linalg.eigvals(column(name).A))
    np.testing.assert_allclose(found, np.sort_complex(np.array(EIGENVALUES)), rtol=1e-7, atol=1e-6)


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize(
    ("outputs", "exact"),
    [((MOTOR,), 6), ((WHEEL,), 6), ((WHEEL, MOTOR), 6), ((BAR,), 5), ((BAR, MOTOR), 6), ((BAR, WHEEL), 6)],
)
def test_exact_ranks_of_the_column(name, outputs, exact):
    system = with_outputs(column(name), outputs)
    assert observability(system).rank == exact
    assert scaled_rank(system).rank == exact
    assert unscaled_rank(sampled(system, 1e-3)).rank == exact
    assert pbh_rank(system) == exact


@pytest.mark.parametrize(
    ("outputs", "printed"), [((BAR,), 4), ((WHEEL, MOTOR), 6), ((BAR, MOTOR), 6), ((BAR, WHEEL), 6)]
)
def test_ranks_of_the_paper_in_double_precision(outputs, printed):
    assert unscaled_rank(with_outputs(column("S3"), outputs)).rank == printed


@pytest.mark.parametrize("name", SETS)
def test_with_disturbances_the_unscaled_matrix_says_five_of_eight_and_every_other_method_eight(name):
    system = extended(column(name), TORQUES)
    assert unscaled_rank(system).rank == 5
    assert scaled_rank(system).rank == observability(system).rank == pbh_rank(system) == 8
    assert [unscaled_rank(sampled(system, step)).rank for step in (1e-4, 1e-3, 1e-2)] == [8, 8, 8]


def test_the_matrix_itself():
    system = LinearSystem.of([[0.0, 1.0], [-2.0, -3.0]], [[1.0, 0.0]])
    np.testing.assert_array_equal(observability_matrix(system.A, system.C), [[1.0, 0.0], [0.0, 1.0]])


def test_the_default_tolerance_is_the_side_times_the_spacing():
    tolerance = 3.0 * 2.0**-52
    assert default_rank(np.diag([1.0, 1.01 * tolerance, 0.99 * tolerance])).rank == 2
    assert default_rank(np.diag([1.99, 1.01 * tolerance, 0.0])).tolerance == tolerance
    assert default_rank(np.zeros((3, 2))).rank == 0
    assert default_rank(np.diag([1.0, 2.0 * tolerance, 1e-30])).margin == pytest.approx(2.0)


def test_units_move_the_unscaled_rank_alone():
    slow = LinearSystem.of([[0.0, 1e-9], [0.0, 0.0]], [[1.0, 0.0]])
    fast = LinearSystem.of([[0.0, 1e-18], [0.0, 0.0]], [[1.0, 0.0]])
    assert unscaled_rank(slow).rank == 2
    assert unscaled_rank(fast).rank == 1
    assert scaled_rank(fast).rank == pbh_rank(fast) == 2


def test_hidden_eigenvectors_are_counted_once_each():
    two = LinearSystem.of(np.diag([-1.0, -1.0, -2.0]), [[0.0, 0.0, 1.0]])
    assert pbh_rank(two) == observability(two).rank == 1
    chain = LinearSystem.of([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]], [[0.0, 0.0, 1.0]])
    assert pbh_rank(chain) == 2
    assert observability(chain).rank == 1
