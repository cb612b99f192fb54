"""Accelerations predicted from the motion, in blocks: against motions in closed form."""

import numpy as np
import pytest

from monitors.condition.demonstrator import CAR, circle
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.accelerations import BLOCK, Blocks, Motion, motion_of
from tierod.monitors.condition.signals import ConditionSample
from tierod.vehicles import load

PARAMETERS = load("smartload").parameters_for(AutomatedVehicle.Parameters)
RATE = 100.0
BOTH = ("wheel_speed_rear_left", "wheel_speed_rear_right")


def signals(columns):
    return dict(zip(ConditionSample._fields, columns.T.copy(), strict=True))


def blocks(*pieces):
    """Ends of the blocks, and the motion in each."""
    cutter, ends, found, start = Blocks(RATE), [], [], 0
    for piece in pieces:
        count = len(piece[BOTH[0]])
        cut, own = cutter.add((start + np.arange(count)) / RATE, piece)
        found += [motion_of(cut, cutter, PARAMETERS)] if own else []
        ends, start = ends + own, start + count
    return ends, Motion(*(np.concatenate(each, axis=-1) for each in zip(*found, strict=True)))


def straight(slope, seconds=5.0):
    """A straight drive whose speed grows evenly."""
    time = np.arange(round(seconds * RATE)) / RATE
    moving = signals(np.zeros((len(time), len(ConditionSample._fields))))
    return moving | dict.fromkeys(BOTH, PARAMETERS.wheel_speed_scale * (5.0 + slope * time))


def test_a_circle_has_yaw_rate_times_speed_across_and_the_centripetal_part_along():
    ends, found = blocks(signals(circle(20.0, 6.0)))
    assert ends == pytest.approx([0.5 * number for number in range(1, 11)])
    np.testing.assert_allclose(found.moved[1], 0.3 * 6.0, rtol=0.06)
    np.testing.assert_allclose(found.moved[0], -0.09 * CAR.rear_distance, atol=0.01)


def test_along_counts_the_slope_of_the_speed():
    _, found = blocks(straight(1.3))
    np.testing.assert_allclose(found.moved, np.repeat([[1.3], [0.0]], 10, axis=1), atol=1e-9)
    assert not found.rough.any()


def test_the_result_does_not_depend_on_the_cuts():
    whole = straight(1.3)
    parts = [
        {name: values[start:stop] for name, values in whole.items()} for start, stop in ((0, 33), (33, 333), (333, 500))
    ]
    (ends, found), (again, same) = blocks(*parts), blocks(whole)
    assert ends == again
    for one, other in zip(found, same, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("wrong", ["yaw_rate", "steering_wheel_angle"])
def test_one_wrong_yaw_rate_of_three_does_not_matter(wrong):
    _, found = blocks(signals(circle(20.0, 6.0, **{wrong: -2.0})))
    assert found.moved[1, 5] == pytest.approx(0.3 * 6.0, rel=0.06)


def test_wheels_that_disagree_show_nothing():
    _, found = blocks(signals(circle(20.0, 6.0, wheel_speed_rear_left=0.0)))
    assert np.isnan(found.moved[:, 5]).all()
    assert np.isnan(found.speed[5])


def test_a_vehicle_that_stands_or_reverses_predicts_nothing():
    for factor in (0.0, -1.0):
        moved = straight(0.0)
        moved |= {name: factor * moved[name] for name in BOTH}
        assert np.isnan(blocks(moved)[1].moved[:, 3]).all()


def test_wheel_speeds_at_twenty_hertz_do():
    sparse = straight(1.3)
    for name in BOTH:
        sparse[name][np.arange(500) % 5 != 0] = np.nan
    ends, found = blocks(sparse)
    assert found.moved[0, 4] == pytest.approx(1.3)
    assert len(ends) == round(5.0 / BLOCK)
