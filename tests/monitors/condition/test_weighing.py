"""Ranks of hypotheses by hand-made ratios, where leaving out one sensor costs more than another."""

import math

import numpy as np
import pytest

from monitors.condition.made_up_lanes import HYPOTHESES, LEFT, MOTOR_1, MOTOR_2, TORQUE
from tierod.monitors.condition.signals import OF_AUTOMATED, Hypothesis
from tierod.monitors.condition.vehicle_filter import PLAUSIBLE, SENSOR_NOISE, prices
from tierod.monitors.condition.weighing import Limits, Weighing, Weights

COUNT = len(HYPOTHESES)
PRICE = 5.0
DEAR = tuple(PRICE if name == TORQUE else 0.0 for name in OF_AUTOMATED)
WEIGHING = Weighing(HYPOTHESES, Limits((1.0,) * (COUNT - 1), (1.0,) * (COUNT - 1), 2.0, 1.0), prices=DEAR)
LEFT_NUMBER, TORQUE_NUMBER, MOTOR_NUMBER = (WEIGHING.number(name) for name in (LEFT, TORQUE, MOTOR_1))


def ranked(observable=None, active=0, weighing=WEIGHING, **scores):
    """The ranking by ratios that are the same fast and slowly, others far below."""
    numbers = {"torque": TORQUE_NUMBER, "left": LEFT_NUMBER, "motor": MOTOR_NUMBER}
    ratios = np.full(COUNT, -20.0)
    ratios[0] = 0.0
    for name, score in scores.items():
        ratios[numbers[name]] = 0.5 * score
    return weighing.ranking(Weights(tuple(ratios), tuple(ratios)), active, observable=observable)


def test_a_cheap_suspect_waits_while_a_dear_one_would_explain_all_else_better():
    found = ranked(motor=20.0, torque=11.0)
    assert (found.best, found.lead) == (MOTOR_NUMBER, 0.0)
    assert found.rivals[MOTOR_NUMBER]
    assert found.rivals[TORQUE_NUMBER]


def test_a_cheap_suspect_is_named_that_explains_all_else_best():
    found = ranked(motor=20.0, torque=9.0)
    assert (found.best, found.lead) == (MOTOR_NUMBER, 11.0)
    assert not found.rivals[TORQUE_NUMBER]


def test_a_dear_suspect_still_has_to_pay():
    found = ranked(motor=12.0, torque=11.0)
    assert found.best == MOTOR_NUMBER
    assert ranked(torque=0.5).exceeding == 0.0


def test_a_sensor_that_gives_no_reading_rivals_no_other():
    result = [0.0 if TORQUE in each.suspects else 1.0 for each in HYPOTHESES]
    assert ranked(result, motor=8.0, torque=0.0).lead == 8.0
    assert ranked(motor=8.0, torque=0.0).lead == 0.0


def test_one_motor_alone_rivals_both_but_both_rival_none_of_them():
    both = Hypothesis("both motors", (), (MOTOR_1, MOTOR_2))
    known = (HYPOTHESES[0], *(each for each in HYPOTHESES if each.suspects in ((MOTOR_1,), (MOTOR_2,))), both)
    weighing = Weighing(known, Limits((1.0,) * 3, (1.0,) * 3, gap=2.0, margin=1.0))

    def lead(*scores):
        ratios = (0.0, *(0.5 * score for score in scores))
        return weighing.ranking(Weights(ratios, ratios), 0)

    found = lead(17.5, 10.0, 20.0)
    assert (found.best, found.lead) == (3.0, 1.5), "less the margin"
    assert found.rivals == (0.0, 1.0, 0.0, 1.0)
    found = lead(18.0, 10.0, 18.5)
    assert (found.best, found.lead) == (1.0, 8.0)
    assert not found.rivals[3]
    assert weighing.ranking(Weights(*((0.0, 0.0, 0.0, 5.0),) * 2), 1).best == 3.0, "the other may follow"


def test_the_price_is_the_mean_logarithm_of_the_density_over_that_of_anything_plausible():
    chance = np.random.default_rng(3).normal(0.0, 0.11, 100_000)
    density = -0.5 * (chance / 0.11) ** 2 - math.log(0.11 * math.sqrt(2.0 * math.pi))
    expected = density.mean() + math.log(60.0)
    assert prices(SENSOR_NOISE, PLAUSIBLE)[OF_AUTOMATED.index(TORQUE)] == pytest.approx(expected, abs=0.01)


def test_only_what_was_against_leaving_out_a_sensor_more_is_remembered_where_another_hypothesis_holds():
    slow = tuple(float(-number) for number in range(COUNT))
    before = Weights((3.0,) * COUNT, slow)
    assert WEIGHING.restarted(before, LEFT_NUMBER, 0.0) == before
    after = WEIGHING.restarted(before, LEFT_NUMBER, 1.0)
    assert set(after.fast) == {0.0}
    for number, each in enumerate(HYPOTHESES):
        assert after.slow[number] == (min(LEFT_NUMBER - number, 0.0) if each.sensors else 0.0)
