import json
from importlib.resources import files

import jsonschema
import pytest

from report_pages import Page
from tierod.cli import main
from tierod.core.claims import Claim, at_most
from tierod.core.content import Heading, Table
from tierod_lab.studies import registry
from tierod_lab.studies.registry import Study

SCHEMA = json.loads(files("tierod.core").joinpath("claims.schema.json").read_text(encoding="utf-8"))


@pytest.fixture
def studies(monkeypatch):
    """Installs studies that give what the test says."""

    def install(**items):
        made = {name: Study(name, f"All about {name}", "A study.", {}) for name in items}
        monkeypatch.setattr(Study, "items", lambda self, effort, progress: items[self.name](effort, progress))
        monkeypatch.setattr(registry, "STUDIES", made)

    return install


def whole(effort, progress):
    progress(0.5, "half of it")
    yield Heading("One", ("Words.",))
    yield Table("Figures", ("what", "much"), (("this", "1"),))
    yield Claim("paper.small", "It is small.", "Somebody", "small", 0.1, at_most(0.3), "N*m")
    yield Claim("paper.long", "It is as long as it is.", "Somebody", None, 7.25, None, "m")
    yield Claim("paper.large", "It is smaller still.", "Somebody", None, 0.1, at_most(0.01 if effort.quick else 0.05))


def test_writes_page_and_claims_and_shows_them(studies, tmp_path, capsys):
    studies(one=whole)
    assert main(["study", "one", "-o", str(tmp_path / "deep" / "er")]) == 0
    claims = json.loads((tmp_path / "deep" / "er" / "claims.json").read_text(encoding="utf-8"))
    jsonschema.validate(claims, SCHEMA)
    assert [row["met"] for row in claims] == [True, None, False]
    page = (tmp_path / "deep" / "er" / "report.html").read_text(encoding="utf-8")
    assert Page(page).open == []
    assert "tierod study one" in page
    captured = capsys.readouterr()
    assert "| this | 1 |" in captured.out
    assert "2 claims: 1 hold, 1 do not, 0 not measured; 1 figures of description" in captured.out
    described, claims = captured.out.split("**Claims**")
    assert "7.25" in described
    assert "paper.long" not in claims
    assert "measuring: half of it" in captured.err
    assert "report.html" in captured.err


def test_a_quick_run_says_so(studies, tmp_path):
    studies(one=whole)
    assert main(["study", "one", "--quick", "-o", str(tmp_path)]) == 0
    assert "quick run" in (tmp_path / "report.html").read_text(encoding="utf-8")
    claims = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    assert [claim["goal"] for claim in claims if "quick run" in claim["note"]] == ["<= 0.3", None, "<= 0.01"]


@pytest.mark.parametrize("error", [RuntimeError("it broke"), KeyboardInterrupt()])
def test_a_study_that_stops_leaves_nothing_half(studies, tmp_path, error):
    def broken(effort, progress):
        yield from whole(effort, progress)
        raise error

    studies(one=broken)
    (tmp_path / "claims.json").write_text("as before")
    assert main(["study", "one", "-o", str(tmp_path)]) in (4, 130)
    assert [path.name for path in tmp_path.iterdir()] == ["claims.json"]
    assert (tmp_path / "claims.json").read_text() == "as before"


def test_two_claims_of_one_name_write_nothing(studies, tmp_path):
    def twice(effort, progress):
        yield from whole(effort, progress)
        yield from whole(effort, progress)

    studies(one=twice)
    assert main(["study", "one", "-o", str(tmp_path)]) == 3
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_is_reported_before_anything_is_measured(studies, tmp_path, capsys):
    def never(effort, progress):
        raise AssertionError("measured all the same")
        yield

    studies(one=never)
    (tmp_path / "file").write_text("no folder")
    assert main(["study", "one", "-o", str(tmp_path / "file")]) == 3
    assert "file exists" in capsys.readouterr().err
