import json
from importlib.resources import files

import jsonschema
import pytest

from report_pages import Page, charts
from tierod.cli import main
from tierod.core.claims import Goal

SCHEMA = json.loads(files("tierod.core").joinpath("claims.schema.json").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_a_quick_study_runs_from_end_to_end(tmp_path, capsys):
    assert main(["study", "friction", "--quick", "-o", str(tmp_path)]) == 0
    claims = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    jsonschema.validate(claims, SCHEMA)
    assert len(claims) > 60
    for row in claims:
        if row["goal"] is not None and row["measured"] is not None:
            assert row["met"] is Goal.read(row["goal"]).holds(row["measured"])
    ended = next(row for row in claims if row["id"] == "plant.drives-ended")
    assert ended["measured"] == 0.0
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert Page(text).open == []
    assert {"figure-3", "figure-5", "figure-6", "figure-7", "figure-8", "figure-9", "figure-10"} <= set(charts(text))
    assert "Table 1" in capsys.readouterr().out
