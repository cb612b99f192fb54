"""What a session keeps beside its finding: nothing for a report that is not asked for, or within the spread."""

import pytest

from tierod.io.derive import complete
from tierod.monitors.harness.session import opened
from tierod.monitors.run import Run
from tierod.monitors.runner import find
from tierod.vehicles import load
from tierod_lab.ground import drive


@pytest.fixture(scope="module")
def recording():
    return drive(minutes=3.0, seed=1)


def test_without_a_report_the_finding_is_the_same(recording):
    monitor, variant = find("friction")
    runs = [Run(monitor, variant, load("midsize-eps"), signals_shown=shown) for shown in (True, False)]
    for run in runs:
        run.add(recording)
    whole, bare = (run.finish() for run in runs)
    assert bare.findings == whole.findings
    assert whole.loops
    assert whole.histograms
    assert not bare.loops
    assert not bare.histograms


@pytest.mark.parametrize("name", ["friction", "sideslip"])
def test_within_the_spread_the_verdict_is_the_same(recording, name):
    monitor, variant = find(name)
    sessions = [opened(monitor, variant, load("midsize-eps")) for _ in range(2)]
    sessions[1].moved, sessions[1].pictured = True, False
    whole = complete(recording, [*monitor.required, *monitor.optional])
    aligned = whole.align(sessions[0].signals, monitor.rate, maximum_age=monitor.maximum_age)
    for session in sessions:
        session.absorb(aligned)
    alone, moved = (session.conclude() for session in sessions)
    assert moved.verdict.status is alone.verdict.status
    assert moved.verdict.estimate == alone.verdict.estimate
    assert moved.elements == alone.elements
    assert not any(each.doubts for each in moved.verdict.facts)
