import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.methods.detectors.measured import threshold_from_records
from tierod.methods.detectors.rule_design import delays_of
from tierod.methods.detectors.stopping_rules import AverageRule, CusumRule, LikelihoodRatioRule


def coloured(count, seed, memory=12.0):
    """White noise beside noise with a memory of some samples, as residuals of motor observers have."""
    from scipy.signal import lfilter

    random = np.random.default_rng(seed)
    decay = np.exp(-1.0 / memory)
    slow = lfilter([np.sqrt(1.0 - decay**2)], [1.0, -decay], random.normal(size=count))
    return 0.75 * slow + 0.66 * random.normal(size=count)


@pytest.mark.parametrize("rule", [CusumRule(0.3), AverageRule(0.05)], ids=["cusum", "average"])
def test_a_threshold_measured_on_coloured_residuals_holds_on_fresh_ones(rule):
    samples = 5000.0
    found = threshold_from_records(rule, [0.1 * coloured(250_000, seed) for seed in (1, 2, 3)], samples)
    fresh = 0.1 * coloured(1_000_000, 9)
    alarms = rule.alarms(scan(rule.block(found.threshold, found.deviation, restart=True), fresh)["alarm"])
    assert not found.extrapolated
    assert len(fresh) / alarms == pytest.approx(samples, rel=0.25)
    assert found.low < samples < found.high
    # What white residuals would need is no use here.
    assert found.threshold > 1.5 * rule.threshold_for(samples)


def test_on_white_residuals_it_is_the_designed_threshold():
    rule = CusumRule(0.5)
    found = threshold_from_records(rule, [np.random.default_rng(1).normal(size=1_000_000)], 5000.0)
    assert found.threshold == pytest.approx(rule.threshold_for(5000.0), rel=0.03)


def test_a_likelihood_ratio_is_measured_too():
    rule = LikelihoodRatioRule((4, 16, 64))
    random = np.random.default_rng(3)
    found = threshold_from_records(rule, [random.normal(size=500_000)], 5000.0)
    alarms = rule.alarms(scan(rule.block(found.threshold, 1.0), random.normal(size=1_000_000))["alarm"])
    assert 1e6 / alarms == pytest.approx(5000.0, rel=0.3)


@pytest.mark.parametrize("samples", [2000.0, 80_000.0])
def test_the_interval_holds_the_true_run_length_as_often_as_it_says(samples):
    rule, held = CusumRule(0.5), 0
    for seed in range(40):
        found = threshold_from_records(rule, [np.random.default_rng([seed, 5]).normal(size=40_000)], samples)
        held += found.low <= rule.run_length(found.threshold) <= found.high
    assert held >= 35  # 38 of 40 are expected; fewer than 35 happen once in 70 times


def test_more_than_was_observed_is_not_claimed():
    found = threshold_from_records(CusumRule(0.5), [np.random.default_rng(2).normal(size=360_000)], 3.6e10)
    assert found.extrapolated
    assert "extrapolated from" in found.claim(1000.0)
    assert "fewer than 30 per hour" in found.claim(1000.0)  # 3 / 0.1 h
    within = threshold_from_records(CusumRule(0.5), [np.random.default_rng(2).normal(size=360_000)], 10_000.0)
    assert "measured" in within.claim(1000.0)


def test_delays_of_shifts_put_into_records():
    rule = CusumRule(0.5)
    threshold = rule.threshold_for(1e5)
    noise = np.random.default_rng(4).normal(size=100_000)
    delays = delays_of(rule.block(threshold, 1.0), [noise], 1.0)
    assert np.mean(delays) == pytest.approx(rule.run_length(threshold, 1.0), rel=0.1)
    assert np.isinf(delays_of(rule.block(threshold, 1.0), [noise], 0.01)).mean() > 0.5


def test_where_a_detector_is_in_alarm_throughout_no_delay_is_reported():
    with pytest.raises(InputError, match="in alarm wherever"):
        delays_of(AverageRule(1.0).block(1.0, 1.0), [np.full(1000, 5.0)], 1.0)


def test_a_slow_average_of_which_alarms_are_rare_is_measured():
    rule = AverageRule(0.005)
    found = threshold_from_records(rule, [np.random.default_rng(7).normal(size=2_000_000)], 20_000.0)
    assert found.threshold == pytest.approx(rule.threshold_for(20_000.0), rel=0.03)
    assert sum(point.alarms >= 8 for point in found.points) >= 6


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
