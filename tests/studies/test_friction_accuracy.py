import math

import pytest

from tierod.errors import ParameterError
from tierod.studies.friction_accuracy import Row, run, table
from tierod.studies.friction_cases import Case, settled_estimates, verdict_of


def test_a_small_study_runs_in_worker_processes():
    rows = run(minutes=6.0, healthy_drives=1, tables=("healthy",), processes=1)
    assert [row.case for row in rows] == ["4 N*m, scatter usual", "4 N*m, scatter hard"]
    assert all(row.figures["hours"] == pytest.approx(0.1, abs=1e-3) for row in rows)
    assert all(row.figures["drives with a false rising or fault"] == 0.0 for row in rows)


def test_every_estimator_gives_a_plausible_friction():
    names = ("default", "single-law estimator", "paper, corrected", "paper, printed")
    found = settled_estimates(Case(1001, 8.0, minutes=7.0), names)
    assert set(found) == set(names)
    assert all(values[-1] == pytest.approx(8.0, abs=1.5) for values in found.values())


def test_a_drive_gives_the_same_figures_again():
    case = Case(1005, 4.0, 12.5, minutes=8.0)
    first, second = verdict_of(case), verdict_of(case)
    assert first == second
    assert not first.early
    assert 0.0 < first.delay[0] < first.delay[1] < 12.0


def test_tables_by_figure_and_by_level():
    rows = [
        Row(
            "steps", "4 to 5.5 N*m", "default", {"fault after": math.inf, "AUC": math.nan, "worst": 1.25, "drives": 3.0}
        ),
        Row("laws", "Dahl", "default", {"truth [N*m]": 4.0, "bias": -0.014, "deviation": 0.02}),
        Row("laws", "Dahl", "default", {"truth [N*m]": 12.5, "bias": 0.31, "deviation": 0.04, "AUC": 0.99}),
    ]
    lines = table(rows).splitlines()
    assert "| 4 to 5.5 N*m | never |  | 1.25 | 3 |" in lines
    assert "| case | estimator | 4 N·m | 12.5 N·m |" in lines
    assert "| Dahl | default | -0.01 ± 0.02 | +0.31 ± 0.04, AUC 0.9900 |" in lines


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seeds": ()}, "no seeds"),
        ({"estimators": ("defualt",)}, "no estimator 'defualt'; did you mean 'default'"),
        ({"tables": ("step",)}, "no table 'step'; did you mean 'steps'"),
    ],
)
def test_a_study_that_cannot_run_is_refused(options, message):
    with pytest.raises(ParameterError, match=message):
        run(**options)


def test_an_unknown_law_is_refused():
    with pytest.raises(ParameterError, match="not a friction law"):
        Case(1, law="Dahl exponent 2").recording()
