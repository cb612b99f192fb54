"""Names and hypotheses of the condition monitor."""

from math import comb

from tierod.core.block import units
from tierod.core.signals import SIGNALS
from tierod.monitors.condition.signals import ACTUATORS, HEALTHY, OF_AUTOMATED, ConditionSample, hypotheses


def test_every_signal_is_canonical_with_its_unit():
    for name, unit in zip(ConditionSample._fields, units(ConditionSample), strict=True):
        assert SIGNALS[name].unit == unit


def test_the_hypotheses_are_all_singles_and_pairs_and_of_two_actuators_those_that_share_a_supply():
    every = hypotheses()
    assert every[0].name == HEALTHY
    assert every[0].suspects == ()
    sensors, actuators = len(OF_AUTOMATED), len(ACTUATORS)
    assert len(every) == 3 + sensors + actuators + comb(sensors, 2) + sensors * actuators
    assert len({frozenset(each.suspects) for each in every}) == len({each.name for each in every}) == len(every)
    assert all(len(each.suspects) <= 2 for each in every)
    together = [each.name for each in every if len(each.actuators) > 1]
    assert together == ["steering_motor_1 + steering_motor_2", "drive_left + drive_right"]
    assert all(set(each.sensors) <= set(OF_AUTOMATED) and set(each.actuators) <= set(ACTUATORS) for each in every)
