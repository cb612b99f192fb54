"""Thresholds of stopping rules: designed, measured, simulated."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.rule_design import RuleDesign, threshold_from_records
from tierod.methods.detectors.stopping_rules import CusumRule, HoldRule, cusum_length


@pytest.mark.parametrize(("threshold", "samples"), [(4.0, 335.37), (5.0, 930.89), (24.0, 1.687125753e11)])
def test_cusum_of_the_literature(threshold, samples):
    assert cusum_length(-0.5, threshold) == pytest.approx(samples, rel=5e-5)


RULES_TRIED = (
    CusumRule(0.5),
    CusumRule(0.1, sides="upper"),
    CusumRule(0.5, sides="lower"),
    HoldRule(3),
    HoldRule(2, sides="upper"),
)
NOISE = np.random.default_rng(11).normal(size=3_000_000)


@pytest.mark.parametrize("rule", RULES_TRIED, ids=lambda rule: f"{rule.name}, {rule.sides}")
def test_the_designed_time_between_false_alarms_is_that_of_a_simulation(rule):
    threshold = rule.threshold_for(1500.0)
    alarms = scan(rule.block(threshold, 2.0, restart=True), 2.0 * NOISE)["alarm"].sum()
    # 2000 alarms are counted: their spread is 2.2 %.
    assert len(NOISE) / alarms == pytest.approx(1500.0, rel=0.08)


@pytest.mark.parametrize("rule", RULES_TRIED, ids=lambda rule: f"{rule.name}, {rule.sides}")
def test_the_designed_delay_is_that_of_a_simulation(rule):
    change = -0.8 if rule.sides == "lower" else 0.8
    threshold = rule.threshold_for(500.0)
    flags = scan(rule.block(threshold, 1.0, restart=True), NOISE[:1_000_000] + change)["alarm"]
    # From alarm to alarm a rule that begins anew takes its delay.
    assert 1e6 / flags.sum() == pytest.approx(rule.run_length(threshold, change), rel=0.04)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: CusumRule(0.5).threshold_for(1.0), "ask for more"),
        (lambda: CusumRule(0.5).threshold_for(math.inf), "finite number"),
        (lambda: CusumRule(1e-5).threshold_for(1e10), "look for a larger shift"),
        (lambda: CusumRule(-0.5), "drift is -0.5"),
        (lambda: HoldRule(0), "1 or more"),
        (lambda: CusumRule(0.5, sides="left"), "sides is 'left'"),
    ],
)
def test_wrong_requests_are_refused(call, says):
    with pytest.raises(ParameterError, match=says):
        call()


def test_white_values_take_the_threshold_that_the_tables_have():
    design = RuleDesign(CusumRule(0.5, sides="upper"), values=930.9, shift=1.0, spacing=1e-3)
    assert design.threshold == pytest.approx(5.0, abs=1e-3)
    assert design.delay(5.0) == pytest.approx(10.38, abs=0.01)  # Page's tables: 10.4 at the shift of one
    assert design.block(2.0) == Cusum(1.0, 2.0 * design.threshold, 4.0 * design.threshold, "upper")


def coloured(count, seed, memory=12.0):
    """White noise beside noise with a memory of some samples, as residuals of motor observers have."""
    from scipy.signal import lfilter

    random = np.random.default_rng(seed)
    decay = np.exp(-1.0 / memory)
    slow = lfilter([np.sqrt(1.0 - decay**2)], [1.0, -decay], random.normal(size=count))
    return 0.75 * slow + 0.66 * random.normal(size=count)


@pytest.mark.parametrize("rule", [CusumRule(0.3)], ids=["cusum"])
def test_a_threshold_measured_on_coloured_residuals_holds_on_fresh_ones(rule):
    samples = 5000.0
    found = threshold_from_records(rule, [0.1 * coloured(250_000, seed) for seed in (1, 2, 3)], samples)
    fresh = 0.1 * coloured(1_000_000, 9)
    alarms = scan(rule.block(found.threshold, found.deviation, restart=True), fresh)["alarm"].sum()
    assert not found.extrapolated
    assert len(fresh) / alarms == pytest.approx(samples, rel=0.25)
    assert found.low < samples < found.high
    # What white residuals would need is no use here.
    assert found.threshold > 1.5 * rule.threshold_for(samples)


def test_more_than_was_observed_is_not_claimed():
    found = threshold_from_records(CusumRule(0.5), [np.random.default_rng(2).normal(size=360_000)], 3.6e10)
    assert found.extrapolated
    assert "extrapolated from" in found.claim(1000.0)
    assert "fewer than 30 per hour" in found.claim(1000.0)  # 3 / 0.1 h
    within = threshold_from_records(CusumRule(0.5), [np.random.default_rng(2).normal(size=360_000)], 10_000.0)
    assert "measured" in within.claim(1000.0)


@pytest.mark.parametrize(
    ("records", "says"),
    [
        ([], "0 healthy residuals are too few"),
        ([np.full(5000, np.nan)], "0 healthy"),
        ([np.zeros(5000)], "all zero"),
        ([np.linspace(1.0, 1.001, 5000)], "remove its mean"),
    ],
)
def test_residuals_that_show_nothing_are_refused(records, says):
    with pytest.raises(InputError, match=says):
        threshold_from_records(CusumRule(0.5), records, 1e4)
