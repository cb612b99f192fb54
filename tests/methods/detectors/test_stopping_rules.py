"""stopping_rules"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtr

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.measured import threshold_from_records
from tierod.methods.detectors.rule_design import RULES, designed
from tierod.methods.detectors.stopping_rules import (
    AverageRule,
    CusumRule,
    ExcessRule,
    HoldRule,
    LikelihoodRatioRule,
    SequentialRule,
    StoppingRule,
)

RULES_TRIED = (
    CusumRule(0.5),
    CusumRule(0.1, sides="upper"),
    CusumRule(0.5, sides="lower"),
    AverageRule(0.1),
    AverageRule(0.2, sides="upper"),
    AverageRule(1.0),
    AverageRule(1.0, sides="lower"),
    HoldRule(3),
    HoldRule(2, sides="upper"),
    SequentialRule(1.0),
    SequentialRule(0.4, sides="lower"),
)
NOISE = np.random.default_rng(11).normal(size=3_000_000)


@pytest.mark.parametrize("rule", RULES_TRIED, ids=lambda rule: f"{rule.name}, {rule.sides}")
def test_the_designed_time_between_false_alarms_is_that_of_a_simulation(rule):
    threshold = rule.threshold_for(1500.0)
    alarms = rule.alarms(scan(rule.block(threshold, 2.0, restart=True), 2.0 * NOISE)["alarm"])
    # 2000 alarms are counted: their spread is 2.2 %.
    assert len(NOISE) / alarms == pytest.approx(1500.0, rel=0.08)


@pytest.mark.parametrize("rule", RULES_TRIED, ids=lambda rule: f"{rule.name}, {rule.sides}")
def test_the_designed_delay_is_that_of_a_simulation(rule):
    change = -0.8 if rule.sides == "lower" else 0.8
    threshold = rule.threshold_for(500.0)
    flags = scan(rule.block(threshold, 1.0, restart=True), NOISE[:1_000_000] + change)["alarm"]
    # From alarm to alarm a rule that begins anew takes its delay, and the sequential test the side that it is on.
    assert 1e6 / rule.alarms(flags) == pytest.approx(rule.run_length(threshold, change), rel=0.04)


def test_siegmund_agrees_for_large_thresholds():
    rule = CusumRule(0.5, sides="upper")
    wide = 8.0 + 1.166  # D. Siegmund, Sequential Analysis (1985), (2.57), for half the shift
    assert rule.run_length(8.0) == pytest.approx((math.exp(wide) - wide - 1.0) / 0.5, rel=0.015)


def test_beyond_what_is_solved_the_line_goes_on():
    rule = CusumRule(0.5)
    within, beyond = rule.threshold_for(5e10), rule.threshold_for(1e14)
    # ln(run length) grows by 2 drift per threshold.
    assert beyond - within == pytest.approx(math.log(1e14 / 5e10) / 1.0, rel=0.01)
    assert beyond == pytest.approx(math.log(1e14) - 1.166, rel=0.01)  # Siegmund, for both sides


def test_closed_forms_need_no_line():
    threshold = AverageRule(1.0).threshold_for(1e14)
    assert 2.0 * ndtr(-threshold) == pytest.approx(1e-14, rel=1e-6)
    assert HoldRule(3).run_length(HoldRule(3).threshold_for(1e14)) == pytest.approx(1e14, rel=1e-6)


@pytest.mark.parametrize("weight", [0.5, 0.05, 0.005])
def test_a_weight_of_any_size_gets_its_threshold(weight):
    rule = AverageRule(weight, sides="upper")
    assert rule.run_length(rule.threshold_for(1e9)) == pytest.approx(1e9, rel=1e-6)


@pytest.mark.parametrize("name", RULES)
def test_a_huge_shift_is_found_in_a_sample(name):
    found = designed(name, 50.0, 1e6)
    assert found.rule.run_length(found.threshold) == pytest.approx(1e6, rel=1e-6)
    assert found.delay == pytest.approx(2.0 if name == "hold" else 1.0, abs=0.01)


@pytest.mark.parametrize("name", RULES)
@pytest.mark.parametrize("sides", ["both", "upper", "lower"])
def test_a_comparison_gives_every_rule_the_same_false_alarms(name, sides):
    found = designed(name, 1.5, 1e5, sides)
    assert found.rule.run_length(found.threshold) == pytest.approx(1e5, rel=1e-3)
    assert found.delay == pytest.approx(found.delay_at(1.5))
    assert found.delay_at(3.0) < found.delay < found.delay_at(0.75)


def test_no_rule_beats_cusum_at_its_shift_by_much():
    delays = {name: designed(name, 1.0, 1e6).delay for name in RULES}
    assert min(delays.values()) > 0.85 * delays["cusum"]
    assert delays["threshold"] > 10.0 * delays["cusum"]


def test_a_likelihood_ratio_finds_shifts_of_every_size():
    block = LikelihoodRatioRule().block(14.0, 1.0)
    for shift, most in ((0.5, 128), (1.0, 64), (4.0, 5)):
        noise = NOISE[:1000].copy()
        noise[500:] += shift
        found = scan(block, noise)
        alarms = np.flatnonzero(found["alarm"] > 0.5)
        assert 500 <= alarms[0] <= 500 + most
    assert found["shift"][600] == pytest.approx(4.0, abs=1.0)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: CusumRule(0.5).threshold_for(1.0), "ask for more"),
        (lambda: CusumRule(0.5).threshold_for(math.inf), "finite number"),
        (lambda: CusumRule(1e-5).threshold_for(1e10), "look for a larger shift"),
        (lambda: LikelihoodRatioRule().threshold_for(1e3), "measure it"),
        (lambda: LikelihoodRatioRule(sides="upper"), "give 'both'"),
        (lambda: CusumRule(-0.5), "drift is -0.5"),
        (lambda: AverageRule(0.0), "weight is 0"),
        (lambda: HoldRule(0), "1 or more"),
        (lambda: SequentialRule(-1.0), "a shift above zero"),
        (lambda: SequentialRule(1.0, lower=1.0), "lower below 0"),
        (lambda: CusumRule(0.5, sides="left"), "sides is 'left'"),
    ],
)
def test_wrong_requests_are_refused(call, says):
    with pytest.raises(ParameterError, match=says):
        call()


@pytest.mark.parametrize("sides", ["both", "upper"])
def test_a_single_look_has_its_threshold_in_closed_form(sides):
    rule = HoldRule(1, sides=sides)
    for samples in (3.0, 1e3, 1e9):
        assert rule.run_length(rule.threshold_for(samples)) == pytest.approx(samples, rel=1e-9)
        assert rule.threshold_for(samples) == pytest.approx(StoppingRule.threshold_for(rule, samples), rel=1e-6)
    with pytest.raises(ParameterError, match="ask for more"):
        rule.threshold_for(0.5)


def test_the_level_is_the_drift_of_a_cumulative_sum():
    rule = ExcessRule(5.0, sides="upper")
    assert rule.run_length(0.5) == CusumRule(0.5, sides="upper").run_length(5.0)
    assert rule.block(0.5, 2.0) == Cusum(1.0, 10.0, 20.0, "upper")
    assert rule.run_length(rule.threshold_for(1e5)) == pytest.approx(1e5, rel=1e-6)


def test_it_alarms_when_the_excess_has_come_together():
    block = ExcessRule(5.0, sides="upper").block(2.0, 1.0)
    assert np.argmax(scan(block, np.full(50, 2.4))["alarm"]) == 12  # 13 values of 0.4
    assert not scan(block, np.full(5000, 1.9))["alarm"].any()


def test_its_level_is_measured_on_residuals_that_remember():
    random = np.random.default_rng(5)
    steps = random.normal(size=100_000) * np.sqrt(1.0 - 0.98**2)
    wander = np.empty_like(steps)
    wander[0] = steps[0]
    for k in range(1, len(steps)):
        wander[k] = 0.98 * wander[k - 1] + steps[k]
    rule = ExcessRule(10.0, sides="upper")
    found = threshold_from_records(rule, [wander[:50_000]], 2000.0)
    alarms = scan(rule.block(found.threshold, found.deviation, restart=True), wander[50_000:])["alarm"].sum()
    assert 50_000 / alarms == pytest.approx(2000.0, rel=0.6)
    assert found.threshold > rule.threshold_for(2000.0)


def test_an_excess_of_nothing_is_refused():
    with pytest.raises(ParameterError, match="greater than zero"):
        ExcessRule(0.0)
