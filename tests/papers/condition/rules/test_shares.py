import numpy as np
import pytest

from tierod.core.graph import scan
from tierod_lab.papers.condition.rules.steering_signals import LostShares

TIME = np.arange(300) * 0.01


def shares(first_lost, second_lost, swing):
    total = 6.0 + 2.0 * np.sin(3.0 * TIME)
    split = 0.5 + np.where(TIME % 0.24 < 0.12, swing, -swing)
    first, second = split * total, (1.0 - split) * total
    missing = first_lost * first + second_lost * second
    result = scan(LostShares(0.4, 0.2, 0.01), np.stack([missing, first, second], axis=1))
    return result["first"][-1], result["second"][-1]


@pytest.mark.parametrize("lost", [(1.0, 0.0), (0.0, 0.5), (0.3, 0.7)])
def test_a_swinging_split_shows_both_shares(lost):
    assert shares(*lost, 0.15) == pytest.approx(lost, abs=0.03)


def test_a_fixed_split_shows_their_sum_alone():
    assert shares(1.0, 0.0, 0.0) == pytest.approx((0.5, 0.5), abs=0.01)


def test_small_torques_are_doubted():
    result = scan(LostShares(0.4, 0.5, 0.01), np.full((300, 3), [0.02, 0.02, 0.0]))
    assert abs(result["first"][-1]) < 0.01
