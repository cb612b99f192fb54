import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.measured import threshold_from_records
from tierod.methods.detectors.rule_design import RuleDesign, RunLengthLine, alarms_at
from tierod.methods.detectors.stopping_rules import AverageRule, CusumRule, HoldRule


def test_white_values_take_the_threshold_that_the_tables_have():
    design = RuleDesign(CusumRule(0.5, sides="upper"), values=930.9, shift=1.0, spacing=1e-3)
    assert design.threshold == pytest.approx(5.0, abs=1e-3)
    assert design.delay(5.0) == pytest.approx(10.38, abs=0.01)  # Page's tables: 10.4 at the shift of one
    assert design.block(2.0) == Cusum(1.0, 2.0 * design.threshold, 4.0 * design.threshold, "upper")


def test_one_look_is_wrong_as_seldom_as_asked():
    design = RuleDesign(HoldRule(1), values=1e3, shift=5.0, spacing=math.inf)
    rule = design.block(0.5)
    assert rule.threshold == pytest.approx(0.5 * 3.2905, abs=1e-3)  # the two-sided 0.1 % point
    random = np.random.default_rng(0)
    false = sum(alarms_at(rule, 0.5 * value) for value in random.normal(size=20_000))
    assert 5 <= false <= 40
    assert alarms_at(rule, -2.0)
    assert not alarms_at(rule, math.nan)


@pytest.mark.parametrize("rule", [CusumRule(0.5), AverageRule(0.1)])
def test_a_measured_line_is_read_both_ways(rule):
    design = RuleDesign(rule, 1e6, 2.0, 0.01, RunLengthLine(2.0, 0.7, 1e5))
    assert math.log(1e6) == pytest.approx(2.0 + 0.7 * rule.growth(design.threshold))
    assert design.run_length(design.threshold) == pytest.approx(1e6)
    assert design.run_length(1.1 * design.threshold) > 1e6


def test_a_line_through_measured_points_gives_the_measured_threshold():
    random = np.random.default_rng(4)
    white = random.normal(size=200_000)
    coloured = np.empty_like(white)
    coloured[0] = white[0]
    for k in range(1, len(white)):
        coloured[k] = 0.9 * coloured[k - 1] + math.sqrt(1.0 - 0.81) * white[k]
    rule = CusumRule(0.5)
    measured = threshold_from_records(rule, [coloured], 5000.0)
    points = [each for each in measured.points if each.alarms >= 8][-6:]
    slope, start = np.polyfit(
        [rule.growth(each.threshold) for each in points],
        np.log([each.run_length for each in points]),
        1,
        w=np.sqrt([each.alarms for each in points]),
    )
    design = RuleDesign(rule, 5000.0, 1.0, 0.01, RunLengthLine(float(start), float(slope), len(coloured)))
    assert design.threshold == pytest.approx(measured.threshold, rel=1e-6)
    block = rule.block(design.threshold, measured.deviation, restart=True)
    alarms = scan(block, coloured)["alarm"].sum()
    assert len(coloured) / alarms == pytest.approx(5000.0, rel=0.5)


def test_too_few_values_are_refused():
    with pytest.raises(ParameterError, match="need no threshold"):
        _ = RuleDesign(CusumRule(0.5), 5.0, 2.0, 0.01, RunLengthLine(2.0, 0.7, 1e5)).threshold
    with pytest.raises(ParameterError, match="rarer with the threshold"):
        RunLengthLine(2.0, -0.7, 1e5)
