"""What shows the sideslip in neutral steer, against the ranks that follow by hand."""

from __future__ import annotations

import pytest

from tierod.vehicles import load
from tierod_lab.papers.sideslip.neutral_steer import OUTPUTS, shown
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle

CAR = load("steer-by-wire").parameters_for(SteeredVehicle.Parameters)
FOUND = {(each.rear_over_neutral, each.speed): each for each in shown(CAR, (0.95, 1.0, 1.05), (6.7, 25.0))}


def ranks(ratio, speed):
    return [each.rank for each in FOUND[ratio, speed].by_outputs]


@pytest.mark.parametrize("speed", [6.7, 25.0])
def test_in_neutral_steer_the_yaw_rate_does_not_hang_on_the_sideslip(speed):
    assert ranks(1.0, speed) == [1, 2, 4, 4]
    (hidden,) = FOUND[1.0, speed].by_outputs[0].hidden.T
    assert abs(hidden[0]) == 1.0
    assert hidden[1] == pytest.approx(0.0, abs=1e-9)
    assert FOUND[1.0, speed].margin == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("ratio", [0.95, 1.05])
def test_a_little_off_it_the_rank_is_full_and_the_margin_small(ratio):
    assert ranks(ratio, 25.0) == [2, 2, 4, 4]
    assert 0.005 < FOUND[ratio, 25.0].margin < 0.05
    assert FOUND[ratio, 25.0].understeer_gradient * (ratio - 1.0) > 0.0


def test_there_is_a_rank_for_every_choice_of_outputs():
    assert len(ranks(1.0, 25.0)) == len(OUTPUTS)
