"""When a verdict turns for a car within the spread, and what is then said."""

from __future__ import annotations

import dataclasses

import pytest

from tierod.core.facts import Fact, Verdict, assemble
from tierod.core.findings import Element, Estimate, ParameterEffect, Status
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.harness.spread.parameter_spread import Outcome
from tierod.monitors.harness.spread.points import Concluded
from tierod.monitors.harness.spread.turning import turn, turn_by_estimate, turned
from tierod.vehicles import Vehicle, load

CAR = load("rav4")


def concluded(status: Status, *faulty: str) -> Conclusion:
    elements = tuple(
        Element(name, "sensor", Status.FAULT if name in faulty else Status.HEALTHY)
        for name in ("yaw_rate", "steering_wheel_angle")
    )
    return Conclusion(Verdict("condition", status), elements=elements)


def outcome(*others: Conclusion) -> Outcome:
    return Outcome({f"track_width{n}": Concluded({"track_width": 1.0}, each) for n, each in enumerate(others)},
                   (), {}, 0.0, None, "")  # fmt: skip


def test_a_fault_of_another_sensor_for_a_car_within_the_spread_turns_the_verdict():
    own, other = concluded(Status.FAULT, "yaw_rate"), concluded(Status.FAULT, "steering_wheel_angle")
    found = turn(own, outcome(own, other))
    assert found is not None
    said = turned(own, found, CAR)
    finding = assemble("Sensors", said.verdict)
    assert finding.headline == "Sensors: suspect, track_width decides the verdict"
    assert "a fault of steering wheel angle" in finding.cause
    assert {each.name: each.status for each in said.elements}["yaw_rate"] is Status.SUSPECT


def test_a_verdict_that_turns_is_not_called_healthy_but_for_the_car_of_the_file():
    estimate = Estimate("friction", 4.5, 0.4, "N*m", {"rising": 5.2, "fault": 7.0})
    low = Fact("healthy", "friction stayed below every limit", action="none; store the learnt level")
    verdict = Verdict("friction", Status.HEALTHY, (low,), estimate)
    effect = ParameterEffect("track_width", 1.6, 0.1, "m", 0.4, "N*m", 1.0)
    found = turn_by_estimate(verdict, 0.2, [effect], CAR)
    assert found is not None
    said = assemble("Friction", turned(Conclusion(verdict), found, CAR).verdict)
    assert said.headline == "Friction: not identifiable, track_width decides the verdict"
    assert said.details == ("ignoring this: healthy, 4.5 ± 0.4 N·m",)
    assert said.cause.endswith("it is rising")
    assert "store" not in said.action


@pytest.mark.parametrize("names", [("yaw_rate",), ("yaw_rate", "steering_wheel_angle")])
def test_the_same_sensor_at_fault_for_every_car_does_not_turn(names):
    own = concluded(Status.FAULT, "yaw_rate")
    assert turn(own, outcome(concluded(Status.FAULT, *names))) is None


def test_a_healthy_car_within_the_spread_turns_a_fault():
    found = turn(concluded(Status.FAULT, "yaw_rate"), outcome(concluded(Status.HEALTHY)))
    assert found is not None
    assert found.status is Status.HEALTHY


GAIN = "torque_gain_deviation"


def with_limit(deviation: float) -> Vehicle:
    car = load("midsize-eps")
    limit = dataclasses.replace(car.parameters["rising_friction"], value=4.8, standard_deviation=deviation)
    return dataclasses.replace(car, parameters={**car.parameters, "rising_friction": limit})


def by_limit(status: Status, value: float) -> Verdict:
    limits = ("rising_friction",) if status is Status.RISING else ()
    estimate = Estimate("friction", value, 0.1, "N*m", {"rising": 5.2}, limits, {GAIN: 0.08 * value})
    return Verdict("friction", status, estimate=estimate)


@pytest.mark.parametrize(("deviation", "turns"), [(0.0, False), (0.5, False), (0.8, True)])
def test_the_deviation_of_a_limit_turns_an_alarm_that_rests_on_it(deviation, turns):
    found = turn_by_estimate(by_limit(Status.RISING, 6.5), 0.0, (), with_limit(deviation))
    assert (found is not None) is turns
    if found is not None:
        assert (found.status, found.names) == (Status.HEALTHY, ("rising_friction", GAIN))


def test_a_healthy_car_of_a_class_with_uncertain_limits_stays_healthy():
    assert turn_by_estimate(by_limit(Status.HEALTHY, 4.5), 0.0, (), with_limit(1.2)) is None


def test_limit_and_parameters_count_together():
    moves = (ParameterEffect("motor_ratio", 18.0, 1.0, "", 0.5, "N*m", 1.0),)
    alarm = by_limit(Status.RISING, 6.5)
    assert turn_by_estimate(alarm, 0.25, moves, with_limit(0.0)) is None
    found = turn_by_estimate(alarm, 0.25, moves, with_limit(0.6))
    assert found is not None
    assert found.names == ("rising_friction", GAIN, "motor_ratio")
