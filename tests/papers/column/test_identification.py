import pytest

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod_lab.papers.column import identification
from tierod_lab.papers.column.identified_bench import EXPERIMENTS, LAWS, bench, recorded
from tierod_lab.studies.effort import Effort


@pytest.mark.slow
def test_a_quick_run_gives_tables_and_claims():
    found = list(identification.items(Effort(quick=True, processes=1)))
    tables = [item.title for item in found if isinstance(item, Table)]
    assert len(tables) == 3
    claims = [item for item in found if isinstance(item, Claim)]
    assert len({claim.id for claim in claims}) == len(claims)
    assert all(claim.met for claim in claims if claim.goal is not None)


@pytest.mark.slow
def test_leave_one_out_has_a_row_per_experiment_and_figure_four():
    table, chart = identification._left_out()
    assert [row[0] for row in table.rows] == list(EXPERIMENTS)
    measured, simulated = chart.panels[0].marks
    assert abs(measured.y - simulated.y).max() < 0.1 * abs(measured.y).max()


def test_names_of_claims_are_fault_free_and_only_exact_models_have_goals():
    errors = dict.fromkeys(identification.MOTOR, -1.0)
    cases = identification._cases(Effort())
    claims = [claim for case in cases for claim in identification._bias(case, errors)]
    assert len({claim.id for claim in claims}) == len(claims) == 3 * len(cases)
    reported = [claim for claim in claims if claim.goal is None]
    assert len(reported) == 3 * (len(LAWS) + 2)
    assert all(claim.measured == -1.0 for claim in reported)


def test_every_seed_has_noise_of_its_own_and_the_same_motion():
    first, again, other = (recorded(bench(), seed, seconds=1.0) for seed in (1, 1, 2))
    assert list(first) == list(EXPERIMENTS)
    for name, recording in first.items():
        same, different = (each[name]["driver_torque"].values for each in (again, other))
        assert (recording["driver_torque"].values == same).all()
        assert 0.0 < abs(recording["driver_torque"].values - different).max() < 0.3
        assert (recording["motor_torque"].values == other[name]["motor_torque"].values).all()
