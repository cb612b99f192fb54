"""When a verdict turns for a car within the spread, and what is then said."""

from __future__ import annotations

import pytest

from tierod.core.findings import Element, Finding, Status
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.harness.spread.parameter_spread import Outcome
from tierod.monitors.harness.spread.points import Concluded
from tierod.monitors.harness.spread.turning import turn, turned
from tierod.vehicles import load

CAR = load("rav4")


def concluded(status: Status, *faulty: str) -> Conclusion:
    elements = tuple(
        Element(name, "sensor", Status.FAULT if name in faulty else Status.HEALTHY)
        for name in ("yaw_rate", "steering_wheel_angle")
    )
    return Conclusion(Finding("condition", status, f"{status}."), elements=elements)


def outcome(*others: Conclusion) -> Outcome:
    return Outcome({f"track_width{n}": Concluded({"track_width": 1.0}, each) for n, each in enumerate(others)},
                   (), {}, 0.0, None, "")  # fmt: skip


def test_a_fault_of_another_sensor_for_a_car_within_the_spread_turns_the_verdict():
    own, other = concluded(Status.FAULT, "yaw_rate"), concluded(Status.FAULT, "steering_wheel_angle")
    found = turn(own, outcome(own, other))
    assert found is not None
    said = turned(own, found, CAR)
    assert said.finding.status is Status.SUSPECT
    assert "a fault of steering wheel angle" in said.finding.cause
    assert "track_width" in said.finding.headline
    assert {each.name: each.status for each in said.elements}["yaw_rate"] is Status.SUSPECT


@pytest.mark.parametrize("names", [("yaw_rate",), ("yaw_rate", "steering_wheel_angle")])
def test_the_same_sensor_at_fault_for_every_car_does_not_turn(names):
    own = concluded(Status.FAULT, "yaw_rate")
    assert turn(own, outcome(concluded(Status.FAULT, *names))) is None


def test_a_healthy_car_within_the_spread_turns_a_fault():
    found = turn(concluded(Status.FAULT, "yaw_rate"), outcome(concluded(Status.HEALTHY)))
    assert found is not None
    assert found.status is Status.HEALTHY
