"""Ranks and declarations over made-up lanes: who is named, when, and what happens to the lanes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from monitors.condition.made_up_lanes import (
    HYPOTHESES,
    LEFT,
    MOTOR_1,
    MOTOR_2,
    RATE,
    RIGHT,
    TORQUE,
    column,
    healthy_drive,
    lane,
)
from tierod.core.block import skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph import Bank, JudgeSample, scan
from tierod.monitors.condition.decision import Decision, SmallLeads
from tierod.monitors.condition.limits import GAP
from tierod.monitors.condition.signals import (
    FRONT_WHEELS,
    OF_AUTOMATED,
    OF_CARS,
    SENSORS,
    WHEELS,
    ConditionSample,
    Hypothesis,
    Readings,
    hypotheses_of_cars,
)
from tierod.monitors.condition.vehicle_filter import PLAUSIBLE, SENSOR_NOISE, LeaveOutFilter, prices
from tierod.monitors.condition.weighing import Limits, Weighing, Weights


@pytest.fixture(scope="module")
def bank():
    count = len(HYPOTHESES) - 1
    limits = Limits((3.0,) * count, (1.0,) * count, gap=1.0, margin=1.0)
    return Bank(tuple(map(lane, HYPOTHESES)), Decision(Weighing(HYPOTHESES, limits)))


@pytest.fixture
def drive():
    return healthy_drive()


def declared(result):
    """(time, name) of every change of the declared hypothesis."""
    numbers = result["hypothesis"].astype(int)
    return [(k / RATE, HYPOTHESES[numbers[k]].name) for k in np.flatnonzero(np.diff(numbers, prepend=-1))]


def test_nothing_is_declared_where_nothing_is_at_fault(bank, drive):
    result = scan(bank, drive)
    assert declared(result) == [(0.0, "healthy")]
    assert not any(result[f"candidates.{name}"].any() for name in OF_AUTOMATED)
    np.testing.assert_array_equal(result[f"value.{LEFT}"], drive[:, 0])


@pytest.mark.parametrize("name", [LEFT, RIGHT])
@pytest.mark.parametrize("size", [1.0, -1.0])
def test_an_offset_is_declared_within_a_tenth_of_a_second_and_taken_back_after_it(bank, drive, name, size):
    drive[300:700, column(name)] += size
    (_, first), (at, second), (back, third) = declared(scan(bank, drive))
    assert (first, second, third) == ("healthy", name, "healthy")
    assert 3.0 < at < 3.1
    assert 7.2 < back < 7.5


def test_a_lost_sensor_is_replaced_from_the_first_sample_on(bank, drive):
    drive[300:, 0] = 0.0
    result = scan(bank, drive)
    assert np.abs(result[f"value.{LEFT}"][300:] - 10.0).max() < 0.1
    assert (result["speed"][300:] > 9.9).all(), "lanes that believe the sensor are corrected from others"
    assert result[f"gated.{LEFT}"][300] == 1.0


def test_a_single_outlier_is_gated_and_not_declared(bank, drive):
    drive[300, 0] += 5.0
    result = scan(bank, drive)
    assert declared(result) == [(0.0, "healthy")]
    np.testing.assert_array_equal(np.flatnonzero(result[f"gated.{LEFT}"]), [300])
    assert abs(result["speed"][301] - 10.0) < 0.05


def test_one_after_another_becomes_a_pair_and_each_recovers_by_itself(bank, drive):
    drive[300:600, 0] = 0.0
    drive[400:800, 1] += 2.0
    names = [name for _, name in declared(scan(bank, drive))]
    assert names == ["healthy", LEFT, "both wheels", RIGHT, "healthy"]


@pytest.mark.parametrize(("lasts", "named"), [(6, False), (100, True)])
def test_a_bump_just_after_a_fault_is_no_second_one(drive, lasts, named):
    limits = Limits((50.0,) * (len(HYPOTHESES) - 1), (1.0,) * (len(HYPOTHESES) - 1), gap=1.0, margin=1.0)
    bank = Bank(tuple(map(lane, HYPOTHESES)), Decision(Weighing(HYPOTHESES, limits)))
    drive[300:, column(LEFT)] = 0.0
    _, (at, _) = declared(scan(bank, drive[:500]))
    bump = round(at * RATE) + 2
    drive[bump : bump + lasts, column(RIGHT)] += 1.0
    names = [name for _, name in declared(scan(bank, drive[: bump + 100]))]
    assert names == ["healthy", LEFT, *(["both wheels"] if named else [])]


def test_a_lost_sensor_does_not_recover_while_it_should_read_zero(bank, drive):
    drive[400:600, column("longitudinal_acceleration")] = -5.0
    drive[:, :2] += np.cumsum(drive[:, column("longitudinal_acceleration")])[:, None] / RATE
    drive[300:, 0] = 0.0
    result = scan(bank, drive)
    assert declared(result)[-1][1] == LEFT
    assert result[f"testable.{LEFT}"][350] == 1.0
    assert result[f"testable.{LEFT}"][-50:].max() == 0.0


def test_no_fault_is_declared_at_standstill(bank, drive):
    drive[100:300, column("longitudinal_acceleration")] = -5.0
    drive[:, :2] += np.cumsum(drive[:, column("longitudinal_acceleration")])[:, None] / RATE
    drive[400:, column(LEFT)] += 1.0
    assert declared(scan(bank, drive)) == [(0.0, "healthy")]


def test_a_wheel_that_brakes_hard_may_lock(bank, drive):
    drive[300:400, column("longitudinal_acceleration")] = -9.0
    drive[:, :2] += np.cumsum(drive[:, column("longitudinal_acceleration")])[:, None] / RATE
    drive[310:390, column(LEFT)] = 0.0
    assert declared(scan(bank, drive)) == [(0.0, "healthy")]


@pytest.mark.parametrize(("acceleration", "named"), [(8.0, False), (-8.0, False), (5.0, True), (np.nan, True)])
def test_no_fault_is_declared_where_the_tyres_slide(bank, drive, acceleration, named):
    drive[300:700, column("lateral_acceleration")] = acceleration
    drive[350:650, column(LEFT)] += 1.0
    result = scan(bank, drive)
    assert (LEFT in [name for _, name in declared(result)]) is named
    assert result[f"testable.{LEFT}"][400:600].max() == float(named)


@pytest.mark.parametrize("share", [1.0, 0.5])
@pytest.mark.parametrize("name", [MOTOR_1, MOTOR_2])
def test_a_motor_is_distinguished_from_the_other_by_the_swing_of_their_split(bank, drive, name, share):
    drive[300:700, column(TORQUE)] -= share * drive[300:700, column(f"{name}_target_torque")]
    result = scan(bank, drive)
    names = [name for _, name in declared(result)]
    assert names == ["healthy", name, "healthy"]
    assert result["torque_loss"][690] == pytest.approx(share, abs=0.05)


def test_both_motors_are_named_where_both_lose_torque_and_no_sooner_than_the_split_has_changed(drive):
    known = (*HYPOTHESES, Hypothesis("both motors", (), (MOTOR_1, MOTOR_2)))
    limits = Limits((3.0,) * (len(known) - 1), (1.0,) * (len(known) - 1), gap=1.0, margin=1.0)
    decision = Decision(Weighing(known, limits))
    drive[300:700, column(TORQUE)] -= 0.5 * drive[300:700, 8:10].sum(axis=1)
    result = scan(Bank(tuple(replace(lane(each), wander=1e-3) for each in known), decision), drive)
    named = (result[f"faulty.{MOTOR_1}"] > 0.5) & (result[f"faulty.{MOTOR_2}"] > 0.5)
    assert 300 + decision.samples_of_both_motors <= np.argmax(named) < 350
    assert named[350:700].all()
    assert not named[-1]
    motors = [known.index(each) for each in known if each.actuators and not each.sensors]
    assert {int(number) for number in result["hypothesis"]} <= {0, *motors}, "one of them at first, no sensor ever"
    assert result["torque_loss"][690] == pytest.approx(0.5, abs=0.05)


def test_motors_that_share_alike_are_named_together(bank, drive):
    drive[:, 8] = drive[:, 9] = 0.5 * (drive[:, 8] + drive[:, 9])
    drive[300:700, column(TORQUE)] -= 0.5 * drive[300:700, 8]
    result = scan(bank, drive)
    both_named = (result[f"candidates.{MOTOR_1}"] > 0.0) & (result[f"candidates.{MOTOR_2}"] > 0.0)
    assert both_named[310:700].all()
    assert not result[f"faulty.{MOTOR_1}"].any()


def test_missing_readings_declare_no_fault(bank, drive):
    drive[300:500, 0] = np.nan
    drive[600:650] = np.nan
    result = scan(bank, drive)
    assert declared(result) == [(0.0, "healthy")]
    assert np.isfinite(result[f"value.{LEFT}"]).all()


def test_limits_are_one_for_each_hypothesis():
    with pytest.raises(ParameterError, match="6 fast limits were given for 7 hypotheses"):
        Weighing(HYPOTHESES, Limits((1.0,) * 6, (1.0,) * 7, 1.0, 1.0))


def test_a_larger_gap_makes_it_wait(bank, drive):
    drive[300:, column(TORQUE)] -= 0.5
    weighing = bank.judge.weighing
    careful = replace(bank.judge, weighing=replace(weighing, limits=replace(weighing.limits, gap=1e3)))
    result = scan(replace(bank, judge=careful), drive)
    assert declared(result) == [(0.0, "healthy")]
    assert result[f"candidates.{TORQUE}"][400:].all()


def test_a_motor_is_not_blamed_for_a_gain_of_the_torque_sensor(bank, drive):
    drive[300:700, column(TORQUE)] *= 1.5
    weighing = bank.judge.weighing
    shipped = replace(bank.judge, weighing=replace(weighing, limits=replace(weighing.limits, gap=GAP)))
    assert declared(scan(replace(bank, judge=shipped), drive)) == [(0.0, "healthy")]


def led_by(lead, small_leads, readings, sliding=-10.0, until=1000, **then):
    """Samples until a wheel is declared that leads the other wheel of its axle by so much; None where it never is.

    From the sample `until` on all filters explain the readings alike where nothing else is given, or say what is.
    """
    explanations = hypotheses_of_cars()[: 1 + len(OF_CARS)]
    limits = Limits((3.0,) * (len(explanations) - 1), (1.0,) * (len(explanations) - 1), gap=2.0, margin=1.0)
    decision = Decision(Weighing(explanations, limits), small_leads=small_leads)
    decision = replace(decision, testability=replace(decision.testability, judged=OF_CARS))
    likely = {WHEELS[0]: 0.0, WHEELS[1]: -0.5 * lead}
    usual = skeleton(LeaveOutFilter.Output)._replace(
        moving=1.0, driven=1.0, prediction=Readings(*(10.0,) * len(SENSORS)), deviation=Readings(*(1.0,) * len(SENSORS))
    )
    lanes = [usual._replace(log_likelihood=likely.get(each.name, -10.0)) for each in explanations]
    lanes.append(usual._replace(log_likelihood=sliding))
    state, sample = decision.init(), skeleton(ConditionSample)._replace(**readings)
    for k in range(200):
        if k == until:
            lanes = [each._replace(**(then or {"log_likelihood": 0.0})) for each in lanes]
        state, verdict = decision.step(state, JudgeSample(sample, tuple(lanes)))
        if verdict.output.hypothesis:
            return k, explanations[int(verdict.output.hypothesis)].name
    return None


ALL_READ = dict.fromkeys(OF_CARS, 10.0)


def test_leads_of_a_wheel_below_the_gap_add_up():
    assert led_by(0.8, None, ALL_READ) is None
    least, most = led_by(1.6, SmallLeads(), ALL_READ), led_by(0.8, SmallLeads(), ALL_READ)
    assert (least[1], most[1]) == (WHEELS[0], WHEELS[0])
    # 50 nat from when both means have settled and are beyond their limits.
    assert 50.0 / 1.6 < least[0] < 50.0 / 1.6 + 60.0
    assert 50.0 / 0.8 < most[0] < 50.0 / 0.8 + 60.0
    assert led_by(0.2, SmallLeads(), ALL_READ) is None


@pytest.mark.parametrize(
    "missing",
    [
        FRONT_WHEELS[0],
        "yaw_rate",
        *(pytest.param(name, marks=pytest.mark.slow) for name in (FRONT_WHEELS[1], "steering_wheel_angle")),
    ],
)
def test_they_count_for_nothing_where_a_sensor_is_missing(missing):
    assert led_by(0.8, SmallLeads(), {**ALL_READ, missing: math.nan}) is None


def test_they_count_for_nothing_where_sliding_tyres_explain_the_readings_too():
    assert led_by(0.8, SmallLeads(), ALL_READ, sliding=-2.0) is None


@pytest.mark.parametrize(
    "then", [{"moving": 0.0}, {"driven": 0.0}, {}], ids=["stands", "brakes", "reads rightly again"]
)
def test_they_count_for_nothing_once_nothing_shows_any_more(then):
    at, _ = led_by(1.9, SmallLeads(), ALL_READ)
    assert led_by(1.9, SmallLeads(), ALL_READ, until=at - 10, **then) is None


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
