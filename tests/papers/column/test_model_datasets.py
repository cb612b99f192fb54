"""Columns with the eigenvalues of Table 3, their reductions, and datasets of the linear model in a small size."""

import control
import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.models.column_observation import linear_column
from tierod.models.linear import LinearSystem, sampled
from tierod.models.steering_column import SteeringColumn
from tierod_lab.papers.column import model_datasets
from tierod_lab.papers.column.columns import EIGENVALUES, SETS, balanced_reduction, gain_of_bar, reduced_columns
from tierod_lab.papers.column.model_datasets import Excitation
from tierod_lab.studies.metrics import Frame

COLUMN = linear_column(SteeringColumn, SETS["S1"])


def stable(seed=3, n=6):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A -= (np.linalg.eigvals(A).real.max() + 0.3) * np.eye(n)
    return LinearSystem.of(A, rng.normal(size=(2, n)), rng.normal(size=(n, 2)), rng.normal(size=(2, 2)))


def ordered(matrix):
    return np.sort_complex(np.linalg.eigvals(matrix))


def test_a_reduction_errs_within_its_bound_and_keeps_the_steady_state():
    whole = stable()
    found = balanced_reduction(whole, 3, {}, {}, shift=0.0)
    reached, shown = control.lyap(whole.A, whole.B @ whole.B.T), control.lyap(whole.A.T, whole.C.T @ whole.C)
    hankel = np.sort(np.sqrt(np.linalg.eigvals(reached @ shown).real))[::-1]
    one, other = (
        control.ss(each.A, each.B, each.C, each.D)(1j * np.geomspace(1e-3, 1e3, 400)) for each in (whole, found)
    )
    worst = np.linalg.svd((one - other).transpose(2, 0, 1), compute_uv=False).max()
    assert 0.2 * hankel[3:].sum() < worst <= 2.0 * hankel[3:].sum()  # K. Glover, 1984
    without = balanced_reduction(whole, 3, {}, {}, feed_through=False, shift=0.0)
    steady, kept, wrong = (each.D - each.C @ np.linalg.solve(each.A, each.B) for each in (whole, found, without))
    np.testing.assert_allclose(kept, steady, atol=1e-9)
    assert np.abs(wrong - steady).max() > 1e-2


@pytest.mark.parametrize(("order", "shift", "says"), [(0, 1.0, "order is 0"), (6, 1.0, "1 to 5"), (4, 0.0, "larger")])
def test_wrong_settings_are_refused(order, shift, says):
    with pytest.raises(ParameterError, match=says):
        balanced_reduction(COLUMN, order, {}, {}, shift=shift)


@pytest.mark.parametrize("name", SETS)
def test_the_columns_have_the_eigenvalues_of_the_table_and_balanced_ones_the_slow_ones(name):
    whole = linear_column(SteeringColumn, SETS[name])
    np.testing.assert_allclose(ordered(whole.A), np.sort_complex(np.array(EIGENVALUES)), atol=1e-6)
    small = reduced_columns(SETS[name])
    np.testing.assert_allclose(ordered(small["balanced"].A), np.sort_complex(np.array(EIGENVALUES[2:])), atol=5e-4)


@pytest.mark.parametrize(
    ("spring", "pair"), [("series", -3.79 + 79.24j), ("torsion bar", -3.79 + 81.57j), ("printed", -3.79 + 81.68j)]
)
def test_mechanical_reductions_have_the_published_frequencies(spring, pair):
    expected = np.sort_complex(np.array([0.0, -8.11, pair, pair.conjugate()]))
    np.testing.assert_allclose(ordered(reduced_columns(SETS["S1"])[f"mechanical, {spring}"].A), expected, atol=6e-3)


def test_the_gain_is_that_of_python_control_also_of_a_sampled_column():
    frequency = np.geomspace(0.1, 300.0, 60)
    peer = control.ss(COLUMN.A, COLUMN.B, COLUMN.C, COLUMN.D)
    row, column = COLUMN.outputs.index("driver_torque"), COLUMN.inputs.index("motor_torque")
    exact = peer(2j * np.pi * frequency)[row, column]
    np.testing.assert_allclose(gain_of_bar(COLUMN, frequency), exact, rtol=1e-8)
    low, step = frequency[:20], 2j * np.pi * frequency[:20] * 1e-4
    held = gain_of_bar(sampled(COLUMN, 1e-4), low, 1e-4)
    np.testing.assert_allclose(held, exact[:20] * (1.0 - np.exp(-step)) / step, rtol=2e-3)


def test_ranks_by_every_method_stand_beside_the_printed_ones():
    found = Frame.of("ranks", model_datasets.ranks("S3"))
    torques = found.where({"sensors": "all, and both torques"})
    assert torques.where({"method": "double precision"})["rank"].tolist() == [5]
    assert set(torques.where({"method": ["staircase", "PBH", "scaled", "rational"]})["rank"]) == {8}
    single = found.where({"sensors": ["steering_wheel_angle", "motor_angle_mechanical"]})
    assert 5 not in single["rank"]
    assert len(single.where({"method": "tolerance 1e-16"})) == 2


def test_a_measured_gain_is_that_of_the_column_and_friction_changes_it():
    (bare,), (weak,) = (model_datasets.frequency_gains(Excitation(each, 60.0, 61)) for each in (0.0, 0.12))
    assert abs(bare["gain_3_to_6_hz"]) < 0.2
    assert bare["peak"] == pytest.approx(12.7, abs=0.3)
    assert weak["gain_3_to_6_hz"] < -3.0


@pytest.mark.slow
def test_parameters_of_the_bench_are_found():
    rows = [*model_datasets.identified(("wheel", 6000)), *model_datasets.identified(("motor", 7000))]
    assert {row["parameter"] for row in rows} == {*model_datasets.WHEEL_SIDE, *model_datasets.MOTOR_SIDE}
    assert all(abs(row["error"]) < min(0.3, 4.0 * row["deviation"]) for row in rows)
