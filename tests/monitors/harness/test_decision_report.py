import dataclasses
import math

import pytest

from tierod.methods.detectors.rule_design import RuleDesign, RunLengthLine
from tierod.methods.detectors.stopping_rules import CusumRule, HoldRule
from tierod.monitors.harness.decision import Decision, OwnRule, curve_of, decided


@dataclasses.dataclass
class Session:
    rule: object


def decision(design, rule=None, place="rule"):
    return Decision("name", "distance", rule or design.block(), place, 1.0, None, "here", design=design)


def test_fewer_false_alarms_cost_delay():
    line = RunLengthLine(2.0, 1.0, 1e5)
    design = RuleDesign(CusumRule(0.5, sides="upper"), math.exp(12.0), 2.5, 0.01, line)
    curve = curve_of(decision(design))
    assert list(curve.up) == sorted(curve.up)
    assert list(curve.along) == sorted(curve.along)
    assert design.threshold == pytest.approx(10.0)
    # ten standard deviations at two a value are five values of a hundredth of a second
    assert curve.chosen == pytest.approx((math.exp(12.0) * 0.01 / 3600.0, 0.05))
    assert not curve.chance


def test_one_look_finds_half_of_what_is_as_large_as_its_threshold():
    design = RuleDesign(HoldRule(1, sides="upper"), 1e3, 4.0, math.inf)
    curve = curve_of(decision(design))
    assert curve.chance
    assert curve.up[0] == pytest.approx(1e-3)
    assert curve.up[-1] == pytest.approx(1.0, abs=2e-3)
    assert curve.chosen == pytest.approx((3.09, 0.5), abs=1e-3)


def test_a_white_rule_has_the_delay_that_it_calculates():
    design = RuleDesign(CusumRule(0.5, sides="upper"), 930.9, 1.0, 1.0)
    assert curve_of(decision(design)).chosen == pytest.approx((930.9 / 3600.0, 10.38), rel=1e-2)


def test_what_the_vehicle_lacks_is_not_reported():
    own = OwnRule("as it is", {})
    there, lacking = decision(None, own), decision(None, own, "gear")
    session = Session(rule=1.0)
    session.gear = None
    result = decided((there, lacking), session)
    assert [each.rule for each in result] == ["as it is"]
    assert result[0].curve is None
