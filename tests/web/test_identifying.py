"""Identification as a job: found once, kept with page and vehicle file, and the file judges recordings."""

import re

import pytest

from tierod.core.errors import ParameterError
from tierod.vehicles import load
from tierod.web.errors import Absent
from tierod.web.jobs import DONE, FAILED
from tierod.web.shapes import Identified
from web_jobs import ended

FILE = "drives/weave.parquet"


def test_a_drive_becomes_a_vehicle_file_once(working, analysed, site):
    asked = Identified(files=[FILE], vehicle="midsize-eps", free=["steering_ratio"])
    done = ended(working.jobs, working.identify(asked))
    assert (done.state, done.text) == (DONE, "")
    key = done.found["identified"]
    found = working.identified(key)
    assert (found["subject"], found["vehicle"], found["files"]) == ("vehicle", "midsize-eps", ["weave.parquet"])
    assert "steering_ratio" in {each["name"] for each in found["judged"]}
    page = working.identified_text(key, "page.html")
    assert "tierod identify vehicle weave.parquet --vehicle midsize-eps" in page
    text = re.sub(r"<[^>]*>", "", page)
    assert "midsize-eps.toml" in text
    assert not {str(analysed.folder), str(load("midsize-eps").path.parent)} & set(re.findall(r"/[\w/.-]+(?=/)", text))
    assert found["written"] == (not found["doubt"])
    if found["written"]:
        learnt = {each["name"]: each["value"] for each in found["parameters"]}
        car = load(done.found["vehicle_file"])
        assert {name: car.parameters[name].value for name in learnt} == pytest.approx(learnt, rel=1e-4)
        name = working.site.name_of(done.found["vehicle_file"])
        assert working.vehicle(name) == done.found["vehicle_file"]
    before = (working.store.path("identified", key) / "page.html").stat().st_ino
    again = ended(working.jobs, working.identify(asked))
    assert again.found == done.found
    assert (working.store.path("identified", key) / "page.html").stat().st_ino == before


def test_what_cannot_be_identified_is_a_sentence(working, analysed):
    with pytest.raises(Absent):
        working.identify(Identified(files=["drives/gone.parquet"], vehicle="midsize-eps"))
    with pytest.raises(ParameterError, match="no-such-car"):
        working.identify(Identified(files=[FILE], vehicle="no-such-car"))
    with pytest.raises(Absent):
        working.identified("0" * 64)
    twice = ended(working.jobs, working.identify(Identified(files=[FILE, FILE])))
    assert twice.state == FAILED
    assert "given twice" in twice.text
    assert str(analysed.folder) not in twice.text
    column = ended(working.jobs, working.identify(Identified(files=[FILE], free=["no_such_parameter"])))
    assert column.state == FAILED
    assert "no_such_parameter" in column.text


def test_endpoints_refuse_what_is_none(client):
    assert client.post("/api/identifications", json={"files": []}).status_code == 422
    assert client.post("/api/identifications", json={"files": [FILE], "subject": "moon"}).status_code == 422
    assert client.get(f"/api/identifications/{'0' * 64}").status_code == 404
    assert client.get("/api/identifications/x/page").status_code == 404
