"""The study of the column as a whole, and its part on position control."""

import json
from importlib.resources import files

import jsonschema
import pytest

from report_pages import Page, charts
from tierod.cli import main
from tierod.core.claims import Claim, Goal
from tierod.core.content import Chart, Table
from tierod_lab.papers.column.position_control import items
from tierod_lab.papers.column.study import PARTS
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.registry import STUDIES

SCHEMA = json.loads(files("tierod.core").joinpath("claims.schema.json").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_position_control_holds_what_it_claims():
    found = list(items(Effort(quick=True, processes=1)))
    claims = [item for item in found if isinstance(item, Claim)]
    assert {claim.group for claim in claims} == {"position"}
    assert not [claim.id for claim in claims if claim.met is False]
    figure = next(item for item in found if isinstance(item, Chart) and item.name == "figure-10")
    assert len(figure.panels) == 6
    assert sum(isinstance(item, Table) for item in found) == 2


@pytest.mark.slow
def test_a_quick_study_runs_from_end_to_end(tmp_path, capsys):
    assert main(["study", "column", "--quick", "-o", str(tmp_path)]) == 0
    claims = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    jsonschema.validate(claims, SCHEMA)
    assert {row["id"].partition(".")[0] for row in claims} == set(STUDIES["column"].groups)
    for row in claims:
        if row["goal"] is not None and row["measured"] is not None:
            assert row["met"] is Goal.read(row["goal"]).holds(row["measured"])
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert Page(text).open == []
    assert "figure-10" in charts(text)
    printed = capsys.readouterr().err
    assert all(title in printed for title in PARTS.values())
