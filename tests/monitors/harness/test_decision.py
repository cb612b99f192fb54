import math

import pytest

from tierod.methods.detectors import Cusum, HeldThreshold
from tierod.monitors.harness.decision import Decision, Demonstrated, OwnRule, rule_in_words


def decision(rule, **more):
    given = {"mean_time_between_false_alarms": None, "demonstrated": Demonstrated(10.0)} | more
    return Decision(
        "alarm",
        "a residual",
        rule,
        "",
        given.pop("mean_time_between_false_alarms"),
        given.pop("demonstrated"),
        "here",
        **given,
    )


def test_the_bound_of_none_is_three_over_what_was_observed():
    assert Demonstrated(14.5).most == pytest.approx(-math.log(0.05) / 14.5)
    # the exact Poisson limit of one event: 4.744
    assert Demonstrated(12.0, 1).most == pytest.approx(4.744 / 12.0, rel=1e-3)


def test_false_alarms_are_reported_as_designed_and_as_shown():
    result = decision(Cusum(0.1, 2.0, 4.0), mean_time_between_false_alarms=1e4).false_alarms_in_words
    assert result == "designed: one in 10 000 h; demonstrated: none in 10 h, so fewer than 0.3 per h at 95 %"
    assert decision(Cusum(0.1, 2.0, 4.0)).false_alarms_in_words.startswith("demonstrated: none in 10 h")


def test_rules_are_reported_in_words():
    assert rule_in_words(HeldThreshold(3.0)) == "threshold 3, either side"
    assert rule_in_words(HeldThreshold(3.0, 5, "upper")) == "threshold 3, above in 5 values one after the other"
    assert rule_in_words(Cusum(0.1, 2.0, 4.0, "lower")) == "cumulative sum, below: drift 0.1 per value, threshold 2"
    assert rule_in_words(OwnRule("as it is", {})) == "as it is"
