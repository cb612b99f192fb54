"""Verdicts that are another one for a car within the spread, and what is then said."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tierod.core.facts import Fact, Verdict, assemble
from tierod.core.findings import Element, Estimate, Finding, Status
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.robustness import robust
from tierod.monitors.uncertainty import Effects, per_deviation
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
    ("own", "other", "status"),
    [
        (("yaw_rate",), ("yaw_rate",), Status.FAULT),
        (("yaw_rate",), ("yaw_rate", "steering_wheel_angle"), Status.FAULT),
        (("yaw_rate",), (), Status.SUSPECT),
    ],
)
def test_a_fault_is_one_for_every_car_within_the_spread(own, other, status):
    lanes = concluded(Status.FAULT if other else Status.HEALTHY, *other)
    assert found(concluded(Status.FAULT, *own), lane(lanes))[0].status is status


def test_lanes_whose_own_reference_has_another_verdict_decide_nothing():
    own = concluded(Status.FAULT, "yaw_rate")
    quiet = concluded(Status.HEALTHY)
    assert found(own, lane(quiet, reference=quiet))[0].status is Status.FAULT
    assert found(own, lane(quiet, reference=own))[0].status is Status.SUSPECT


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


def test_a_verdict_that_turns_is_not_called_healthy_but_for_the_car_of_the_file():
    finding, _ = found(friction(Status.HEALTHY, 4.5), shift(trail=0.9))
    assert finding.details == ("ignoring this: healthy, 4.5 ± 0.9 N·m",)
    assert finding.cause.endswith("it is rising")
    assert "store" not in finding.action


def test_a_fault_within_the_interval_of_a_healthy_estimate_is_named_with_its_reason():
    scattered = friction(Status.HEALTHY, 7.9, fault=8.0)
    finding, _ = found(scattered, None)
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert "scatter of the estimate may hide a fault" in finding.cause


def with_limit(deviation: float) -> Vehicle:
    limit = dataclasses.replace(CAR.parameters["rising_friction"], value=4.8, standard_deviation=deviation)
    return dataclasses.replace(CAR, parameters={**CAR.parameters, "rising_friction": limit})


LIMITED = friction(Status.RISING, 6.5, ("rising_friction",), rising=5.2)


@pytest.mark.parametrize(("deviation", "status"), [(0.0, Status.RISING), (0.5, Status.RISING), (0.8, Status.SUSPECT)])
def test_the_deviation_of_a_limit_turns_an_alarm_that_rests_on_it(deviation, status):
    finding, _ = found(LIMITED, None, with_limit(deviation))
    assert finding.status is status
    if status is Status.SUSPECT:
        assert "rising_friction and torque_gain_deviation" in finding.cause


def test_a_healthy_car_of_a_class_with_uncertain_limits_stays_healthy():
    assert found(friction(Status.HEALTHY, 4.5, rising=5.2), None, with_limit(1.2))[0].status is Status.HEALTHY


def test_limit_and_parameters_count_together():
    moves = shift(motor_ratio=0.5)
    assert found(LIMITED, moves, with_limit(0.0))[0].status is Status.RISING
    finding, _ = found(LIMITED, moves, with_limit(0.6))
    assert "rising_friction, torque_gain_deviation and motor_ratio" in finding.cause


def test_a_change_per_standard_deviation_is_the_root_mean_square_of_both_sides():
    base, sides = np.array([1.0, 2.0, 1.0]), {2.0: np.array([3.0, np.nan, 5.0]), -2.0: np.array([-3.0, 0.0, 5.0])}
    assert per_deviation(sides, base) == pytest.approx([np.sqrt(2.5), 1.0, 2.0])
    assert per_deviation({}, base) == pytest.approx([0.0, 0.0, 0.0])


def test_a_lane_without_a_fault_doubts_one_whose_magnitude_has_another_unit_than_the_statistic():
    fault = Verdict("condition", Status.FAULT, estimate=Estimate("offset of the yaw rate", 0.02, 0.002, "rad/s"))
    healthy = Conclusion(Verdict("condition", Status.HEALTHY))
    found = robust(
        Conclusion(fault), Effects({("mass", 2.0): healthy}, None, {"mass": 1.5}, 1.0, "", None), CAR, True, False
    )
    assert assemble("Sensors", found.conclusion.verdict).status is Status.SUSPECT
