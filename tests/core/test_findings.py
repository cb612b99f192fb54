"""Findings: causes and remedies that are put before others."""

import pytest

from tierod.core.findings import Finding, Status


@pytest.mark.parametrize(
    ("cause", "action", "joined"),
    [
        ("", "none", ("late", "repair")),
        ("drift", "calibrate", ("late; drift", "repair; calibrate")),
        ("", "none; store the level", ("late", "repair")),
    ],
)
def test_a_cause_before_another_keeps_no_empty_words(cause, action, joined):
    finding = Finding("friction", Status.HEALTHY, "4 N·m.", cause=cause, action=action).after("late", "repair")
    assert (finding.cause, finding.action) == joined
