"""What a fact does to a verdict: status, headline, cause, action, details and warnings."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import tierod
import tierod_lab
from tierod.core.facts import Fact, Verdict, assemble, defect
from tierod.core.findings import Estimate, Status

ESTIMATE = Estimate("largest sideslip angle", 0.3, 0.01, "rad")
FRICTION = Estimate("friction", 8.1, 0.72, "N*m")
ANOTHER_CAR = defect((), "the file is another car's", withholds=True)


@pytest.mark.parametrize("status", [Status.NOT_ENABLED, Status.NOT_IDENTIFIABLE, Status.ESTIMATED])
def test_a_defect_that_withholds_the_estimate_leaves_none_in_the_finding(status):
    late = defect(("yaw_rate",), "yaw_rate is late")
    found = assemble("Sideslip", Verdict("sideslip", status, (), ESTIMATE), [late, ANOTHER_CAR], {"yaw_rate"})
    assert found.estimate is None
    assert found.status is Status.INCONSISTENT
    assert found.headline == "Sideslip: inconsistent, yaw_rate is late"
    assert found.cause == "yaw_rate is late; the file is another car's"
    assert "17" not in " ".join((found.headline, *found.details))


@pytest.mark.parametrize(
    ("status", "expected"),
    [
        (Status.HEALTHY, Status.SUSPECT),
        (Status.RISING, Status.SUSPECT),
        (Status.FAULT, Status.SUSPECT),
        (Status.ESTIMATED, Status.INCONSISTENT),
        (Status.CONSISTENT, Status.INCONSISTENT),
        (Status.NOT_IDENTIFIABLE, Status.NOT_IDENTIFIABLE),
        (Status.NOT_READY, Status.NOT_READY),
    ],
)
def test_a_defect_of_a_needed_signal_leaves_no_verdict_as_it_was(status, expected):
    verdict = Verdict("any", status, (Fact("own", "its own cause"),), ESTIMATE)
    late = defect(("yaw_rate",), "yaw_rate is late, by 0.2 s")
    found = assemble("Angle", verdict, [late], {"yaw_rate"})
    assert (found.status, found.estimate) == (expected, ESTIMATE)
    if expected is Status.NOT_READY:
        assert (found.cause, found.warnings) == ("its own cause", ("yaw_rate is late, by 0.2 s",))
    else:
        assert found.headline == f"Angle: {expected}, yaw_rate is late"
        assert found.cause.startswith("yaw_rate is late, by 0.2 s")
    beside = assemble("Angle", verdict, [late], {"vehicle_speed"})
    assert (beside.status, beside.warnings) == (status, ("yaw_rate is late, by 0.2 s",))


def test_what_was_judged_in_part_only_is_not_healthy_and_an_alarm_stays():
    lost = Fact("judged time", "the speed is missing", allows=Status.NOT_IDENTIFIABLE)
    for status, expected in ((Status.HEALTHY, Status.NOT_IDENTIFIABLE), (Status.FAULT, Status.FAULT)):
        assert assemble("Angle", Verdict("any", status), [lost]).status is expected


def test_an_alarm_that_is_doubted_keeps_its_own_cause_and_says_what_it_was():
    worn = Fact("worn", "friction rose", action="inspect the gear")
    late = defect(("yaw_rate",), "yaw_rate is late, by 0.2 s")
    found = assemble("Friction", Verdict("friction", Status.FAULT, (worn,), FRICTION, 120.4), [late])
    assert found.headline == "Friction: suspect, yaw_rate is late"
    assert found.cause == "yaw_rate is late, by 0.2 s; friction rose"
    assert found.action.startswith("repair the sensor")
    assert found.action.endswith("; inspect the gear")
    assert found.details == ("ignoring this: fault, 8.1 ± 0.7 N·m since 120 s",)


def test_a_quiet_verdict_that_is_taken_back_keeps_neither_cause_nor_remedy():
    low = Fact("low", "friction stayed below every limit", action="none; store the level")
    lost = Fact("judged time", "the speed is missing", action="repair it", allows=Status.NOT_IDENTIFIABLE)
    found = assemble("Friction", Verdict("friction", Status.HEALTHY, (low,), FRICTION), [lost])
    assert (found.cause, found.action) == ("the speed is missing", "repair it")
    assert assemble("Friction", Verdict("friction", Status.HEALTHY, (low,))).action == "none; store the level"


def test_a_warning_adds_its_remedy_unless_the_cause_names_its_signal():
    stuck = Fact("stuck", "speed is stuck", action="repair or check speed", rests_on=("speed",))
    verdict = Verdict("friction", Status.HEALTHY, (Fact("low", "below every limit", action="none"),))
    found = assemble("Friction", verdict, [stuck])
    assert (found.action, found.warnings) == ("repair or check speed", ("speed is stuck",))
    late = defect(("torque",), "torque is late")
    assert assemble("Friction", verdict, [late], {"speed"}).action == "none"
    lost = Fact("judged time", "speed is missing", action="record again", allows=Status.NOT_IDENTIFIABLE)
    assert assemble("Friction", verdict, [lost, stuck]).action == "record again"


def test_findings_are_made_in_one_place():
    roots = [Path(package.__file__).parent for package in (tierod, tierod_lab)]
    makers = {
        f"{path.parent.name}/{path.name}"
        for root in roots
        for path in root.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Finding"
    }
    assert makers == {"core/facts.py"}


def test_a_doubt_of_the_monitor_itself_outlives_what_lowers_its_verdict():
    low = Fact("low", "{estimate} is only half of the nominal friction", action="check the gains")
    late = defect(("yaw_rate",), "yaw_rate is late, by 0.2 s")
    found = assemble("Friction", Verdict("friction", Status.HEALTHY, (low,), FRICTION), [late], {"yaw_rate"})
    assert found.status is Status.SUSPECT
    assert found.warnings == ("8.1 ± 0.7 N·m is only half of the nominal friction",)
    assert "check the gains" in found.action
