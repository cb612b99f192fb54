"""Limits of the bank: designed on the tail of what healthy drives show, kept in a vehicle file, read back."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.monitors.condition.limits import (
    BLOCK,
    FACTOR,
    NAME,
    SETTLING,
    block_maxima,
    designed_on,
    has_own_limits,
    limits_of,
    table_of,
)
from tierod.monitors.condition.signals import hypotheses
from tierod.vehicles import load
from tierod.vehicles.writer import with_thresholds

COUNT = len(hypotheses()) - 1
CAR = load("smartload")
PER_HOUR = 3600.0 / BLOCK


def blocks(hours=20.0, scale=4.0, start=20.0, seed=3):
    """Ratios of every ten seconds, all alike but for one hypothesis that has an exponential tail above `start`."""
    count = round(hours * PER_HOUR)
    ratios = np.full((count, 2 * COUNT), 0.01)
    ratios[:, 4] = start + np.random.default_rng(seed).exponential(scale, count)
    return ratios


def test_the_factor_is_that_of_the_exponential_tail():
    scale, start, hours = 4.0, 20.0, 1e6
    found = designed_on(blocks(20.0, scale, start), hours)
    # The limit is where an exponential tail is exceeded once in so many hours: start + scale ln(blocks).
    limit = found.limits.fast[4]
    assert limit == pytest.approx(start + scale * math.log(hours * PER_HOUR), rel=0.1)
    assert found.hours_between_alarms == pytest.approx(hours, rel=1e-6)
    assert found.hours == pytest.approx(20.0)


def test_a_longer_time_gives_wider_limits_and_never_less_than_the_least_factor():
    short, long, longer = (designed_on(blocks(), hours) for hours in (1.0, 1e6, 1e7))
    assert short.factor == FACTOR
    assert short.hours_between_alarms > 1.0
    assert longer.factor > long.factor > FACTOR
    assert longer.limits.fast[4] > long.limits.fast[4]


def test_the_designed_time_passes_between_alarms_of_an_exponential_tail(monkeypatch):
    monkeypatch.setattr("tierod.monitors.condition.limits.FACTOR", 0.0)
    between = []
    for seed in range(12):
        found = designed_on(blocks(20.0, 12.0, 4.0, seed), 60.0)
        ratios = 4.0 + np.random.default_rng(100 + seed).exponential(12.0, round(2000.0 * PER_HOUR))
        alarms = np.count_nonzero(ratios > found.limits.fast[4])
        between.append(math.log(2000.0 / alarms / found.hours_between_alarms))
        assert found.hours_between_alarms == pytest.approx(60.0)
    assert abs(np.mean(between)) < math.log(1.5)


def true_hours(limit, start, scale):
    """Between alarms of an exponential tail."""
    return math.exp((limit - start) / scale) / PER_HOUR


@pytest.mark.parametrize("wanted", [10.0, 1e5])
def test_far_beyond_what_was_seen_and_at_the_least_factor_the_time_is_that_of_the_tail(wanted):
    designed = [designed_on(blocks(20.0, 12.0, 4.0, seed), wanted) for seed in range(12)]
    between = [math.log(true_hours(found.limits.fast[4], 4.0, 12.0) / found.hours_between_alarms) for found in designed]
    assert abs(np.mean(between)) < math.log(1.5)


def test_the_time_that_few_blocks_allow_is_shorter_most_of_the_time():
    designed = [designed_on(blocks(1.0, 12.0, 4.0, seed), 1000.0) for seed in range(20)]
    assert all(found.hours_at_least < found.hours_between_alarms for found in designed)
    kept = [true_hours(found.limits.fast[4], 4.0, 12.0) > found.hours_at_least for found in designed]
    assert sum(kept) >= 17


def test_hours_in_which_the_vehicle_stands_do_not_count():
    standing = designed_on(blocks(), 1e6, 10.0)
    assert standing.hours == 10.0
    assert standing.factor > designed_on(blocks(), 1e6).factor - 1e-9
    with pytest.raises(InputError, match="hold 6.0 minutes"):
        designed_on(blocks(), 1000.0, 0.1)


def test_alarms_of_the_other_half_are_counted():
    half = len(blocks()) // 2
    ratios = blocks()
    ratios[half + 3, 7] = 40.0
    ratios[half + 9, 7] = 30.0
    assert designed_on(ratios, 1000.0).alarms_before - designed_on(blocks(), 1000.0).alarms_before == 2


def test_a_limit_lies_well_above_what_was_seen_where_that_was_next_to_nothing():
    found = designed_on(blocks(), 1000.0)
    assert found.limits.fast[0] == pytest.approx(2.01 * found.factor)
    assert found.limits.slow[0] == pytest.approx(1.01 * found.factor)


def test_blocks_leave_the_beginning_and_the_healthy_hypothesis_out():
    width, skipped = round(BLOCK * 100.0), round(SETTLING * 100.0)
    ratios = np.zeros((skipped + 2 * width + 5, 2 * (COUNT + 1)))
    ratios[skipped - 1] = 99.0
    ratios[skipped + width : skipped + width + 3, 1] = 3.0
    ratios[skipped + width + 5 : skipped + width + 7, 1] = 30.0  # too short for the judge to speak
    ratios[skipped : skipped + 3, COUNT + 1] = ratios[skipped : skipped + 3, 0] = 7.0
    ratios[-1] = 99.0
    found = block_maxima(ratios)
    assert found.shape == (2, 2 * COUNT)
    assert found[1, 0] == 3.0
    assert found[0].max() == 0.0


def test_too_little_driving_and_no_time_are_refused():
    with pytest.raises(InputError, match="hold 6.0 minutes.*need 15 minutes.*better an hour"):
        designed_on(blocks(0.1), 1000.0)
    with pytest.raises(ParameterError, match="0 h between false alarms"):
        designed_on(blocks(), 0.0)


def test_limits_go_into_a_vehicle_file_and_come_back(tmp_path):
    designed = designed_on(blocks(), 1000.0)
    text = with_thresholds('name = "x"\nsource = "made up"\n', NAME, table_of(designed, "a drive"))
    import tomllib

    kept = replace(CAR, thresholds=tomllib.loads(text)["thresholds"])
    read = limits_of(kept)
    np.testing.assert_allclose(read.fast, designed.limits.fast, rtol=1e-3)
    np.testing.assert_allclose(read.slow, designed.limits.slow, rtol=1e-3)
    assert (read.gap, read.margin) == (designed.limits.gap, designed.limits.margin)
    assert has_own_limits(kept)


def test_the_shipped_vehicle_has_limits_and_is_not_calibrated():
    assert min(*limits_of(CAR).fast, *limits_of(CAR).slow) > 0.0
    assert not has_own_limits(CAR)


def changed(**changes):
    table = table_of(designed_on(blocks(), 1000.0), "a drive")
    return replace(CAR, thresholds={NAME: {**table, **changes}})


@pytest.mark.parametrize(
    ("vehicle", "message"),
    [
        (replace(CAR, thresholds={}), "no limits of the condition monitor; 'tierod identify thresholds'"),
        (changed(fast={"yaw_rate": 3.0}), "fast.*lacks 'wheel_speed_rear_left'"),
        (changed(slow=3.0), "slow.*lacks 'wheel_speed_rear_left'"),
        (changed(fast={each.name: 1.0 for each in hypotheses()}), "holds unknown hypotheses"),
        (changed(slow={each.name: 0.0 for each in hypotheses()[1:]}), "numbers above zero"),
        (changed(gap="wide"), "numbers above zero"),
    ],
)
def test_a_table_that_cannot_be_meant_is_refused(vehicle, message):
    with pytest.raises(ParameterError, match=message):
        limits_of(vehicle)
