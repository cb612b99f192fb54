import math
from dataclasses import dataclass

import pytest

from tierod.methods.detectors import Cusum, HeldThreshold
from tierod.monitors.harness.decision import Decision, Demonstrated, OwnRule, rule_in_words


@dataclass
class Part:
    rule: object
    hold: float = 0.01


@dataclass
class Session:
    block: Part


def decision(rule, place="block.rule", **more):
    given = {"mean_time_between_false_alarms": None, "demonstrated": Demonstrated(10.0)} | more
    return Decision(
        "alarm",
        "a residual",
        rule,
        place,
        given.pop("mean_time_between_false_alarms"),
        given.pop("demonstrated"),
        "here",
        **given,
    )


def test_the_bound_of_none_is_three_over_what_was_observed():
    assert Demonstrated(14.5).most == pytest.approx(-math.log(0.05) / 14.5)
    # the exact Poisson limit of one event: 4.744
    assert Demonstrated(12.0, 1).most == pytest.approx(4.744 / 12.0, rel=1e-3)


def test_a_declared_rule_is_compared_with_the_one_in_effect():
    rule = Cusum(0.1, 2.0, 4.0)
    assert decision(rule).departures(Session(Part(Cusum(0.1, 2.0, 4.0)))) == ()
    assert "declared" in decision(rule).departures(Session(Part(Cusum(0.1, 2.1, 4.2))))[0]
    assert "declared" in decision(rule).departures(Session(Part(HeldThreshold(2.0))))[0]
    assert "has no block.sum" in decision(rule, "block.sum").departures(Session(Part(rule)))[0]


def test_limits_are_compared_one_by_one():
    limits = OwnRule("beyond 3 A for 10 ms", {"hold": 0.01, "rule.threshold": 3.0})
    assert decision(limits, "block").departures(Session(Part(HeldThreshold(3.0)))) == ()
    found = decision(limits, "block").departures(Session(Part(HeldThreshold(4.0), 0.02)))
    assert len(found) == 2
    assert decision(limits, "block").departures(Session(Part(None)))


def test_false_alarms_are_reported_as_designed_and_as_shown():
    result = decision(Cusum(0.1, 2.0, 4.0), mean_time_between_false_alarms=1e4).false_alarms_in_words
    assert result == "designed: one in 10 000 h; demonstrated: none in 10 h, so fewer than 0.3 per h at 95 %"
    assert decision(Cusum(0.1, 2.0, 4.0)).false_alarms_in_words.startswith("demonstrated: none in 10 h")


def test_rules_are_reported_in_words():
    assert rule_in_words(HeldThreshold(3.0)) == "threshold 3, either side"
    assert rule_in_words(HeldThreshold(3.0, 5, "upper")) == "threshold 3, above in 5 values one after the other"
    assert rule_in_words(Cusum(0.1, 2.0, 4.0, "lower")) == "cumulative sum, below: drift 0.1 per value, threshold 2"
    assert rule_in_words(OwnRule("as it is", {})) == "as it is"
