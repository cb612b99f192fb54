"""The study of the motor's angle as a whole."""

import json
from importlib import import_module
from importlib.resources import files

import jsonschema
import pytest

from report_pages import Page, charts
from tierod.cli import main
from tierod.core.claims import Goal
from tierod_lab.papers.motor_angle.study import PARTS
from tierod_lab.studies.registry import STUDIES

SCHEMA = json.loads(files("tierod.core").joinpath("claims.schema.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", PARTS)
def test_every_part_says_what_it_finds(name):
    assert import_module(f"tierod_lab.papers.motor_angle.{name}").items.__doc__


@pytest.mark.slow
def test_a_quick_study_runs_from_end_to_end(tmp_path, capsys):
    assert main(["study", "motor-angle", "--quick", "-o", str(tmp_path)]) == 0
    claims = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    jsonschema.validate(claims, SCHEMA)
    assert {row["id"].partition(".")[0] for row in claims} == set(STUDIES["motor-angle"].groups)
    for row in claims:
        if row["goal"] is not None and row["measured"] is not None:
            assert row["met"] is Goal.read(row["goal"]).holds(row["measured"])
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert Page(text).open == []
    assert {f"motor-angle-figure-{number}" for number in range(4, 8)} <= set(charts(text))
    printed = capsys.readouterr().err
    assert all(title in printed for title in PARTS.values())
