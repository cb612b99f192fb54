"""Metrics against figures worked out by hand, and what is said of a wrong file of claims."""

import math
from importlib import import_module
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest

from tierod.core.claims import Claim, Goal
from tierod.core.content import Heading, Table
from tierod.core.errors import ParameterError
from tierod_lab import papers
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.engine import Claims, Dataset, items
from tierod_lab.studies.metrics import METRICS, Frame, metric
from tierod_lab.studies.registry import STUDIES

FILES = sorted(Path(papers.__file__).parent.glob("*/claims.toml"))
ROWS = [
    {"method": "one", "speed": 10.0, "error": -3.0, "found": 1.0},
    {"method": "one", "speed": 30.0, "error": 4.0, "found": 0.0},
    {"method": "two", "speed": 30.0, "error": 1.0, "found": 1.0},
    {"method": "two", "speed": 50.0, "error": 2.0, "found": 1.0},
]


def drive(task):
    """What the methods err.

    A second paragraph.
    """
    return ROWS[task : task + 2]


DATASET = Dataset("errors", "Errors", drive, lambda effort: [0, 2])


def claims_of(tmp_path, text, datasets=(DATASET,)):
    path = tmp_path / "claims.toml"
    path.write_text(text, encoding="utf-8")
    return list(items(path, datasets, Effort(processes=1), lambda share, what: None))


def claim(keys, tmp_path):
    text = f'[[claim]]\nid = "group.name"\nclaim = "It is."\ndataset = "errors"\n{keys}\n'
    return next(each for each in claims_of(tmp_path, text) if isinstance(each, Claim))


@pytest.mark.parametrize(
    ("text", "figure"),
    [
        ("count", 4.0),
        ("sum error", 4.0),
        ("mean error", 1.0),
        ("bias error", 1.0),
        ("median error", 2.0),
        ("std error", math.sqrt(26.0 / 4.0)),
        ("rms error", math.sqrt(30.0 / 4.0)),
        ("min error", -3.0),
        ("max error", 4.0),
        ("p05 error", 1.0),
        ("p95 error", 4.0),
        ("limit found", 7.753656528457288),
        ("sum found / count", 0.75),
    ],
)
def test_every_metric_of_four_rows(text, figure):
    found = metric(text, Frame.of("errors", ROWS))
    assert found == pytest.approx(figure)
    assert text.split()[0] in METRICS


@pytest.mark.parametrize(
    ("keys", "figure"),
    [
        ('metric = "max error"\nwhere = { method = "two" }', 2.0),
        ('metric = "count"\nwhere = { speed = ">= 30" }', 3.0),
        ('metric = "count"\nwhere = { speed = [10.0, 50.0], method = "one" }', 1.0),
        ('metric = "rms error"\nwhere = { speed = 30.0 }\nover = { speed = "<= 20" }', math.sqrt(8.5) / 3.0),
        ('metric = "mean found"\nby = ["method"]\nacross = "min"', 0.5),
        ('metric = "max error"\nwhere = { speed = 50.0 }\nover = { speed = 30.0 }', 0.5),
    ],
)
def test_a_claim_takes_its_figure_from_the_rows_that_count(keys, figure, tmp_path):
    assert claim(keys, tmp_path).measured == pytest.approx(figure)


def test_too_few_rows_are_not_judged_and_missing_data_is_said(tmp_path):
    found = claim('metric = "max error"\nleast = 5\ngoal = "<= 1"', tmp_path)
    assert (found.measured, found.met) == (None, None)
    assert "4 of 5 rows" in found.note
    empty = Dataset("errors", "Errors", lambda task: [], lambda effort: [1], "The recording is not here.")
    text = '[[claim]]\nid = "a.b"\nclaim = "It is."\ndataset = "errors"\nmetric = "max error"\n'
    (said,) = [each for each in claims_of(tmp_path, text, (empty,)) if isinstance(each, Claim)]
    assert said.measured is None
    assert said.note == "The recording is not here."


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ('metric = "largest error"', "'group.name': 'largest' is no metric"),
        ('metric = "max eror"', "'group.name': the dataset 'errors' has no column 'eror'; did you mean 'error'"),
        ('metric = "max error"\ngoal = "small"', "'group.name': 'small' is not a goal"),
        ('metric = "max error"\nwhere = { spede = 3.0 }', "no column 'spede'"),
        ('metric = "max error"\ngaol = "<= 1"', "a claim has no key 'gaol'; did you mean 'goal'"),
        ("", "lacks 'metric'"),
        ('metric = "max error"\nwhere = { speed = 30.0 }\nover = { speed = 99.0 }', "no row of 'errors'"),
    ],
)
def test_a_wrong_row_is_named_with_its_line(keys, said, tmp_path):
    with pytest.raises(ParameterError, match=r"claims\.toml, line \d+: ") as raised:
        claim(keys, tmp_path)
    assert said in str(raised.value)


def test_a_dataset_that_is_not_there_and_a_name_given_twice_are_refused(tmp_path):
    row = '[[claim]]\nid = "a.b"\nclaim = "It is."\ndataset = "errors"\nmetric = "max error"\n'
    with pytest.raises(ParameterError, match="there is no dataset 'erors'; did you mean 'errors'"):
        claims_of(tmp_path, row.replace("errors", "erors"))
    with pytest.raises(ParameterError, match="the claim 'a.b' stands twice"):
        claims_of(tmp_path, row + row)


def test_a_study_shows_dataset_heading_table_and_claim(tmp_path):
    text = (
        '[[claim]]\nid = "a.b"\nclaim = "It is."\ndataset = "errors"\nmetric = "max error"\ngoal = "<= 5"\n'
        '[[table]]\ndataset = "errors"\ntitle = "Errors"\nby = ["method"]\ncolumns = { most = "max error" }\n'
    )
    frame, heading, table, found = claims_of(tmp_path, text)
    assert heading == Heading("Errors", ("What the methods err.", "A second paragraph."))
    assert isinstance(table, Table)
    assert table.rows == (("one", "4"), ("two", "2"))
    assert found.met
    written = pyarrow.parquet.read_table(frame.write(tmp_path)).to_pydict()
    np.testing.assert_array_equal(written["error"], [-3.0, 4.0, 1.0, 2.0])


@pytest.mark.parametrize("path", FILES, ids=[path.parent.name for path in FILES])
def test_every_file_of_claims_is_valid(path):
    study = STUDIES[path.parent.name.replace("_", "-")]
    claims = Claims.read(path)
    datasets = {each.name for each in import_module(f"tierod_lab.papers.{path.parent.name}.study").DATASETS}
    assert {each.dataset for each in (*claims.measures, *claims.overviews)} <= datasets
    assert {each.id.partition(".")[0] for each in claims.measures} == set(study.groups)
    for each in claims.measures:
        assert each.metric.split()[0] in METRICS
        assert Goal.read(each.goal)


@pytest.mark.slow
@pytest.mark.parametrize("path", FILES, ids=[path.parent.name for path in FILES])
def test_every_dataset_of_a_quick_study_has_the_columns_of_its_claims(path):
    claims = Claims.read(path)
    for dataset in import_module(f"tierod_lab.papers.{path.parent.name}.study").DATASETS:
        frame = dataset.frame(Effort(quick=True))
        assert list(claims.items(dataset, frame))
