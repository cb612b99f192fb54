"""What a vehicle file and drives say together of the motor's ratio: the product of two normal distributions."""

import dataclasses

import pytest

from tierod.methods.identification.vehicle_judgement import LEARNT, NOT_SEEN
from tierod.monitors.own_car import NAME, DriveRatio, _judged
from tierod.vehicles import load

PLAIN = load("midsize-eps")
FILE = dataclasses.replace(
    PLAIN,
    parameters={
        **PLAIN.parameters,
        NAME: dataclasses.replace(PLAIN.parameters[NAME], value=20.0, standard_deviation=1.0),
    },
)


def test_drives_and_file_that_agree_are_put_together():
    found = _judged(FILE, DriveRatio(21.0, 0.5, 0.02))
    assert found.kind == LEARNT
    assert (found.value, found.deviation) == (pytest.approx((20.0 + 4.0 * 21.0) / 5.0), pytest.approx(0.2**0.5))


@pytest.mark.parametrize(("value", "kept"), [(24.0, False), (25.0, True), (15.0, True)])
def test_a_contradiction_beyond_four_deviations_of_both_leaves_the_file(value, kept):
    found = _judged(FILE, DriveRatio(value, 0.5, 0.02))
    assert (found.kind == NOT_SEEN) is kept
    if kept:
        assert (found.value, found.deviation) == (20.0, 1.0)
        assert f"{5.0 / 1.25**0.5:.1f} σ from the file" in found.text
