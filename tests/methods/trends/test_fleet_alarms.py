"""Alarms of a fleet: bounds and lists."""

import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.methods.trends.fleet_alarms import alarm_level, log_e_values, selected


def test_the_level_is_the_time_between_false_alarms():
    assert alarm_level(10_000.0) == pytest.approx(math.log(3_652_500.0))
    with pytest.raises(ParameterError, match="expected a positive number"):
        alarm_level(0.0)


def test_e_values_of_cars_without_a_change_have_a_mean_of_one():
    # the statistic in days has the time watched as its mean
    watched = np.array([0.0, 100.0, 5000.0])
    with np.errstate(divide="ignore"):
        e = np.exp(log_e_values(np.log(watched), watched, 3650.0))
    np.testing.assert_allclose(e, 1.0)


def test_the_list_keeps_its_share_of_wrong_cars():
    chance = np.random.default_rng(4)
    shares = []
    for _ in range(400):
        changed = np.arange(200) < 20
        z = chance.standard_normal(200) + np.where(changed, 4.0, 0.0)
        chosen = selected(3.0 * z - 4.5, 0.1)
        shares.append((chosen & ~changed).sum() / max(chosen.sum(), 1))
    assert np.mean(shares) <= 0.1
    assert selected(np.array([0.0, 0.0]), 0.1).sum() == 0
    assert selected(np.log([25.0, 12.0, 1.0]), 0.2).tolist() == [True, True, False][:3]


def test_a_share_outside_its_range_is_refused():
    with pytest.raises(ParameterError, match="false-discovery rate is 1"):
        selected(np.zeros(3), 1)
