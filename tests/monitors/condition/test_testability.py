"""Hard bends: for how long no element is accused in them and after them."""

import math

import pytest

from tierod.monitors.condition import weighing as testability


def cornered(accelerations, lacks=0.0, before=0.0):
    found = []
    for acceleration in accelerations:
        before = testability.Testability().cornered(before, acceleration, lacks, 0.01)
        found.append(bool(before > 0.5))
    return found, before


@pytest.mark.parametrize("acceleration", [8.0, -8.0])
def test_tyres_may_slide_for_half_a_second_after_a_hard_bend(acceleration):
    found, _ = cornered([acceleration, *[5.0] * 100])
    assert sum(found) == 50
    assert all(found[:50])


def test_they_do_for_as_long_as_an_axle_lacks_force_in_it():
    _, before = cornered([8.0])
    assert all(cornered([5.0] * 300, lacks=1.0, before=before)[0])


@pytest.mark.parametrize(("acceleration", "lacks"), [(5.0, 1.0), (math.nan, 0.0)])
def test_no_force_that_is_lacking_nor_a_missing_acceleration_makes_a_hard_bend(acceleration, lacks):
    assert not any(cornered([acceleration] * 10, lacks)[0])
