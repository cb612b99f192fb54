"""Findings: the words under which they are shown."""

import pytest

from tierod.core.findings import Finding, Status


@pytest.mark.parametrize(
    ("status", "confirmed", "word"),
    [
        (Status.HEALTHY, None, ""),
        (Status.HEALTHY, False, "estimated"),
        (Status.HEALTHY, True, "consistent"),
        (Status.SUSPECT, False, "inconsistent"),
        (Status.SUSPECT, True, "inconsistent"),
        (Status.NOT_ENABLED, True, ""),
    ],
)
def test_an_estimate_is_never_called_healthy(status, confirmed, word):
    finding = Finding("sideslip, combined", status, "Up to 3 degrees.", confirmed=confirmed)
    assert finding.word == word
    assert finding.shown_status == (word or str(status))
    assert finding.screen().title.endswith(finding.shown_status)


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
