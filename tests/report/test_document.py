import dataclasses
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import tierod.report
from diagnosis_examples import EXAMPLES, friction_fault
from tierod.core.findings import Status
from tierod.report import to_json
from tierod.report.document import SCHEMA, plain

SHIPPED = json.loads((Path(tierod.report.__file__).parent / "diagnosis.schema.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", EXAMPLES)
@pytest.mark.parametrize("series", [False, True])
def test_every_document_keeps_to_the_shipped_schema(name, series):
    document = json.loads(to_json(EXAMPLES[name](), series))
    jsonschema.validate(document, SHIPPED, jsonschema.Draft202012Validator)
    assert document["schema"] == SCHEMA
    order = list(document)
    assert order.index("status") < order.index("findings") < order.index("elements") < order.index("quality")
    assert order[-1] == "recording", "of a simulation it holds every parameter of the plant"


def test_the_schema_is_one_and_names_every_status():
    jsonschema.Draft202012Validator.check_schema(SHIPPED)
    assert SHIPPED["properties"]["schema"]["const"] == SCHEMA
    assert set(SHIPPED["properties"]["status"]["enum"]) == {str(status) for status in Status}


@pytest.mark.parametrize(
    "spoil",
    [
        lambda document: document.pop("findings"),
        lambda document: document.update(status="broken"),
        lambda document: document["findings"][0].update(more=1),
        lambda document: document["findings"][0]["estimate"].update(value="12"),
    ],
)
def test_the_schema_refuses_other_documents(spoil):
    document = json.loads(to_json(friction_fault()))
    spoil(document)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, SHIPPED, jsonschema.Draft202012Validator)


def test_what_cannot_be_said_is_null():
    assert plain({"a": float("nan"), "b": (np.inf, 1)}) == {"a": None, "b": [None, 1]}
    assert plain(np.array([1.0, np.nan])) == [1.0, None]
    assert plain([np.int64(3), np.float32(0.5), np.bool_(True), Path("x"), None]) == [3, 0.5, True, "x", None]


def test_the_decisive_finding_decides_status_and_exit_code():
    document = json.loads(to_json(friction_fault()))
    assert (document["status"], document["exit_code"]) == ("fault", 1)
    assert document["findings"][0]["estimate"]["interval"] == pytest.approx([12.2144, 12.6456])
    assert json.loads(to_json(EXAMPLES["nothing"]()))["exit_code"] == 2


def test_series_are_whole():
    diagnosis = friction_fault()
    document = json.loads(to_json(diagnosis, series=True))
    assert set(document["traces"]) == set(diagnosis.traces)
    gap = np.isnan(diagnosis.traces["yaw_rate"].mean)
    assert [value is None for value in document["traces"]["yaw_rate"]["mean"]] == gap.tolist()
    assert len(document["histograms"]["0 to 15 min"]["edges"]) == 61


def test_unknown_metadata_does_not_break_it():
    diagnosis = dataclasses.replace(friction_fault(), recording={"path": Path("a"), "bus": {"a": object()}})
    assert json.loads(to_json(diagnosis))["recording"]["path"] == "a"


def test_parameters_stand_by_how_far_they_move_the_result_and_an_estimate_has_its_word():
    document = json.loads(to_json(EXAMPLES["estimated"]()))
    assert [each["name"] for each in document["parameter_effects"]] == ["rear_distance", "steering_ratio"]
    assert document["parameter_effects"][0]["effect"] == pytest.approx(0.0605)
    assert document["findings"][0]["status"] == document["status"] == "estimated"
    assert document["exit_code"] == 0
