"""Columns with the eigenvalues of Table 3, their reductions, and datasets of the linear model in a small size."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.models.column_observation import linear_column
from tierod.models.linear import LinearSystem
from tierod.models.steering_column import SteeringColumn
from tierod_lab.methods.ranks import unscaled_rank
from tierod_lab.papers.column import model_datasets
from tierod_lab.papers.column.columns import (
    EIGENVALUES,
    SETS,
    balanced_column,
    damping_ratio,
    extended,
    member,
    vibrations,
)
from tierod_lab.papers.column.identified_bench import EXPERIMENTS, bench, recorded
from tierod_lab.papers.column.model_datasets import Excitation, Member, rational_rank
from tierod_lab.studies.metrics import Frame


def test_constant_torques_become_states():
    larger = extended(linear_column(SteeringColumn, SETS["S1"]))
    assert larger.states[-2:] == ("hand_torque", "disturbance_torque")
    np.testing.assert_array_equal(larger.A[-2:], 0.0)


def test_modes_slowest_first():
    values = vibrations(linear_column(SteeringColumn, SETS["S1"]))
    np.testing.assert_allclose(np.abs(values), [0.0, 8.1149, 79.7504, 706.7509], atol=1e-3)
    assert damping_ratio(values[2]) == pytest.approx(0.0481496, abs=1e-6)
    assert math.isnan(damping_ratio(0j))


@pytest.mark.parametrize("name", SETS)
def test_the_balanced_column_of_every_set_keeps_the_slow_eigenvalues(name):
    eigenvalues = np.sort_complex(np.linalg.eigvals(balanced_column(SETS[name]).system.A))
    expected = [-8.1149075, -3.8399224 - 79.6578986j, -3.8399224 + 79.6578986j, 0.0]
    np.testing.assert_allclose(eigenvalues, expected, atol=5e-4)


@pytest.mark.parametrize(
    ("stiffness", "ratio", "inertia"), [(700.0, 8.0, 0.03), (3100.0, 20.0, 0.04), (5500.0, 15.0, 0.05)]
)
def test_every_member_of_the_family_has_the_eigenvalues_of_the_table(stiffness, ratio, inertia):
    parameters = member(stiffness, ratio, inertia)
    found = np.sort_complex(np.linalg.eigvals(linear_column(SteeringColumn, parameters).A))
    np.testing.assert_allclose(found, np.sort_complex(np.array(EIGENVALUES)), atol=1e-6)
    assert min(vars(parameters).values()) > 0.0
    assert parameters.torsion_bar_stiffness / inertia == pytest.approx(stiffness)


def test_rational_arithmetic_rounds_nothing():
    tiny = LinearSystem.of([[0.0, 1e-30], [0.0, 0.0]], [[1.0, 0.0]])
    assert rational_rank(tiny) == 2
    assert unscaled_rank(tiny).rank == 1
    assert rational_rank(LinearSystem.of(np.diag([-1.0, -1.0]), [[1.0, 1.0]])) == 1


def test_ranks_by_every_method_stand_beside_the_printed_ones():
    found = Frame.of("ranks", model_datasets.ranks(Member("S3")))
    torques = found.where({"sensors": "all, and both torques"})
    assert torques.where({"method": "double precision"})["rank"].tolist() == [5]
    assert set(torques.where({"method": ["staircase", "PBH", "scaled", "rational"]})["rank"]) == {8}
    single = found.where({"sensors": ["steering_wheel_angle", "motor_angle_mechanical"]})
    assert 5 not in single["rank"]
    assert len(single.where({"method": "tolerance 1e-16"})) == 2
    assert found.where({"sensors": "driver_torque", "method": "double precision"})["rank"].tolist() == [4]


def test_ranks_are_counted_and_not_assumed(monkeypatch):
    parted = replace(member(700.0, 8.0, 0.03), torsion_bar_stiffness=0.0)  # two bodies that see nothing of the third
    monkeypatch.setattr(model_datasets, "member", lambda *given: parted)
    found = Frame.of("ranks", model_datasets.ranks(Member("parted")))
    ranks = found.where({"method": "staircase"})
    by = {each: ranks.where({"sensors": each})["rank"][0] for each in (model_datasets.WHEEL, model_datasets.MOTOR)}
    assert by == {"steering_wheel_angle": 2, "motor_angle_mechanical": 4}


def test_the_series_spring_is_the_best_mechanical_one_and_the_balanced_column_better_still():
    found = {row["reduction"]: row for row in model_datasets.reductions(None)}
    assert found["balanced"]["error"] < 0.5 < found["mechanical, series"]["error"]
    assert found["mechanical, series"]["error"] < found["mechanical, torsion bar"]["error"]
    assert found["balanced"]["feed_through"] == pytest.approx(0.0929, rel=0.01)
    assert all(row["rank"] == 6 for row in found.values())


def test_a_measured_gain_is_that_of_the_column_and_friction_changes_it():
    (bare,), (weak,) = (model_datasets.frequency_gains(Excitation(each, 60.0, 61)) for each in (0.0, 0.12))
    assert bare["gain_error"] < 0.2
    assert bare["peak"] == pytest.approx(12.7, abs=0.3)
    assert weak["gain_3_to_6_hz"] < -3.0


def test_every_seed_has_noise_of_its_own_and_the_same_motion():
    first, again, other = (recorded(bench(), seed, seconds=1.0) for seed in (1, 1, 2))
    assert list(first) == list(EXPERIMENTS)
    for name, recording in first.items():
        same, different = (each[name]["driver_torque"].values for each in (again, other))
        assert (recording["driver_torque"].values == same).all()
        assert 0.0 < abs(recording["driver_torque"].values - different).max() < 0.3
        assert (recording["motor_torque"].values == other[name]["motor_torque"].values).all()


@pytest.mark.slow
def test_parameters_of_the_bench_are_found():
    rows = [*model_datasets.identified(("wheel", 6000)), *model_datasets.identified(("motor", 7000))]
    assert {row["parameter"] for row in rows} == {*model_datasets.WHEEL_SIDE, *model_datasets.MOTOR_SIDE}
    assert max(row["size"] for row in rows) < 0.3
    noisy = model_datasets.unknown_benches(("motor torque noise 0.01 N·m", 200, model_datasets.SHORT))
    assert max(row["size"] for row in noisy) < 1.0
