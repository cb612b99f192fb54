"""Verdicts that are another one for a car within the spread, and what is then said."""

from __future__ import annotations

import pytest

from tierod.core.facts import Fact, Verdict, assemble
from tierod.core.findings import Element, Estimate, Finding, Status
from tierod.monitors.robustness import robust
from tierod.monitors.session import Conclusion
from tierod.monitors.uncertainty import Effects
from tierod.vehicles import Vehicle, load

CAR, GAIN = load("midsize-eps"), "torque_gain_deviation"


def concluded(status: Status, *faulty: str) -> Conclusion:
    names = ("yaw_rate", "steering_wheel_angle")
    elements = (Element(name, "sensor", Status.FAULT if name in faulty else Status.HEALTHY) for name in names)
    return Conclusion(Verdict("condition", status), elements=tuple(elements))


def found(own: Conclusion, effects: Effects | None, car: Vehicle = CAR) -> tuple[Finding, Conclusion]:
    """Finding and conclusion for a car with uncertain parameters."""
    conclusion, _ = robust(own, effects, car, may_turn=True, learns=False)
    return assemble("Subject", conclusion.verdict), conclusion


def lane(other: Conclusion, reference: Conclusion | None = None) -> Effects:
    """The vehicle with another mass has another conclusion; its statistic changes by half of its threshold."""
    return Effects({("mass", -2.0): other}, reference, {"mass": 0.5}, 1.0, "", None)


def shift(**deviations: float) -> Effects:
    """Parameters that shift an estimate of friction by so much."""
    return Effects({}, None, deviations, 0.1, "N*m", None)


def friction(status: Status, value: float, limits: tuple[str, ...] = (), **reference: float) -> Conclusion:
    gain = {GAIN: 0.08 * value} if limits else {}
    estimate = Estimate("friction", value, 0.1, "N*m", reference or {"rising": 6.0, "fault": 8.0}, limits, gain)
    low = Fact("healthy", "friction stayed below every limit", action="none; store the learnt level")
    return Conclusion(Verdict("friction", status, (low,) if status is Status.HEALTHY else (), estimate))


def test_a_fault_of_another_sensor_for_a_car_within_the_spread_is_suspect():
    own, other = concluded(Status.FAULT, "yaw_rate"), concluded(Status.FAULT, "steering_wheel_angle")
    finding, conclusion = found(own, lane(other))
    assert finding.headline == "Subject: suspect, mass decides the verdict"
    assert "a fault of steering wheel angle" in finding.cause
    assert {each.name: each.status for each in conclusion.elements}["yaw_rate"] is Status.SUSPECT


@pytest.mark.parametrize(
    ("own", "value", "deviation", "status"),
    [
        (Status.HEALTHY, 4.0, 1.1, Status.NOT_IDENTIFIABLE),
        (Status.HEALTHY, 4.0, 0.9, Status.HEALTHY),
        (Status.FAULT, 9.0, 1.6, Status.SUSPECT),
        (Status.FAULT, 9.0, 1.4, Status.FAULT),
        (Status.NOT_READY, 4.0, 9.0, Status.NOT_READY),
    ],
)
def test_a_verdict_turns_where_two_deviations_pass_the_limit(own, value, deviation, status):
    finding, _ = found(friction(own, value), shift(trail=deviation))
    assert finding.status is status
    assert ("trail decides the verdict" in finding.headline) is (status is not own)


def test_a_lane_without_a_fault_doubts_one_whose_magnitude_has_another_unit_than_the_statistic():
    fault = Verdict("condition", Status.FAULT, estimate=Estimate("offset of the yaw rate", 0.02, 0.002, "rad/s"))
    healthy = Conclusion(Verdict("condition", Status.HEALTHY))
    found = robust(
        Conclusion(fault), Effects({("mass", 2.0): healthy}, None, {"mass": 1.5}, 1.0, "", None), CAR, True, False
    )
    assert assemble("Sensors", found.conclusion.verdict).status is Status.SUSPECT
