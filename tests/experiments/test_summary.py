"""From rows to gates, document and table."""

import json
from importlib.resources import files
from types import SimpleNamespace

import jsonschema
import pytest

from experiments.campaign_rows import row
from tierod.core.claims import Goal
from tierod.core.toml import Document
from tierod_lab.campaign.pools import Gate, pass_through
from tierod_lab.campaign.summary import Summary, document, text

SCHEMA = json.loads(files("tierod_lab.campaign").joinpath("campaign.schema.json").read_text(encoding="utf-8"))
STEP = {"fault": "step", "size": 4}
ROWS = (
    row(1), row(2, verdict="false alarm", false_alarms=1),
    row(1, **STEP, detection_s=5.0, detection_enabled_s=2.0), row(2, **STEP, verdict="missed"),
    row(1, fault="lost", verdict="early", false_alarms=1), row(2, fault="lost", outcome="diverged", reason="gone"),
)  # fmt: skip


def summary(rows=ROWS, gates=()):
    axes = {}
    for each in rows:
        for axis, level in each.place.items():
            axes.setdefault(axis, {})[level] = None
    judge = SimpleNamespace(
        label="friction", monitor="friction", variant="v", belief=SimpleNamespace(name="car"), learns=False
    )
    campaign = SimpleNamespace(
        file=SimpleNamespace(name="test", description="As the test wants."),
        document=Document.parse('name = "test"'),
        plan=SimpleNamespace(judges=(judge,)),
        axes={axis: list(levels) for axis, levels in axes.items()},
        hours=1.0,
    )
    return Summary(campaign, tuple(rows), tuple(pass_through(gate, rows) for gate in gates))


def gate(figure, goal, **where):
    return Gate(figure, Goal.read(goal), where, "friction")


def test_gates_are_met_missed_or_not_to_be_judged():
    fault_free = pass_through(gate("false_alarms", "<= 1", fault="fault-free"), ROWS)
    assert (fault_free.measured, fault_free.met) == (1.0, True)
    assert pass_through(gate("detection_worst_s", "<= 10", fault="step"), ROWS).met is False
    assert pass_through(gate("detection_median_s", "<= 10", **STEP), ROWS).met is True
    assert pass_through(gate("area", ">= 0.5", fault="fault-free"), ROWS).met is None


def test_a_gate_over_drives_that_failed_can_be_missed_but_not_met():
    lost = pass_through(gate("false_alarms", "<= 1", fault="lost"), ROWS)
    assert (lost.met, lost.note) == (None, "1 of 2 drives failed, so it cannot be judged as met")
    assert pass_through(gate("false_alarms", "= 0", fault="lost"), ROWS).met is False


@pytest.mark.parametrize(
    ("gates", "status", "code"),
    [
        ([], "no gates", 0),
        ([gate("false_alarms", "<= 9")], "not judged", 2),
        ([gate("false_alarms", "<= 9", fault="fault-free")], "met", 0),
        ([gate("false_alarms", "<= 9"), gate("missed_share", "= 0", fault="step")], "missed", 1),
    ],
)
def test_the_exit_code_follows_the_gates(gates, status, code):
    found = summary(gates=gates)
    assert (found.status, found.exit_code) == (status, code)


def test_the_document_keeps_to_its_schema():
    content = document(summary(gates=[gate("detection_worst_s", "<= 10")]), "tierod campaign test.toml")
    content = json.loads(text(content))
    jsonschema.validate(content, SCHEMA)
    assert content["pools"][0]["figures"]["detection_worst_s"] == "inf"
    assert content["states"][0]["confusion"]["lost"] == {"fault": 1, "no verdict": 1}
    assert [cell["outcome"] for cell in content["cells"]] == ["driven"] * 5 + ["diverged"]
    assert content["cells"][5]["verdicts"] == [{"monitor": "friction", "reason": "gone", "status": None}]
