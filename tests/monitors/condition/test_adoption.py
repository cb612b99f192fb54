"""Which lane goes on from which: two sensors disagree, and one sample is all but impossible to most."""

import pytest

from monitors.condition.made_up_lanes import LEFT, RIGHT, TORQUE
from tierod.core.graph import KEEP
from tierod.monitors.condition.decision import adopted, best_pair_containing, selected_lane
from tierod.monitors.condition.signals import Hypothesis

HYPOTHESES = (
    Hypothesis("healthy"),
    Hypothesis(LEFT, (LEFT,)),
    Hypothesis(RIGHT, (RIGHT,)),
    Hypothesis("left and torque", (LEFT, TORQUE)),
    Hypothesis("right and torque", (RIGHT, TORQUE)),
)
IMPOSSIBLE = 12.0


def taken(likelihoods, changed=0.0):
    """Of every lane the one whose state it goes on from."""
    source, far_off = selected_lane(HYPOTHESES, likelihoods, 0.0, IMPOSSIBLE)
    nearest = best_pair_containing(HYPOTHESES, likelihoods, IMPOSSIBLE)
    return adopted(HYPOTHESES, source, nearest, far_off, changed, source if changed else 0.0)


@pytest.mark.parametrize("ahead", [1.0, -1.0])
def test_of_two_sensors_that_disagree_each_lane_keeps_to_the_one_that_it_trusts(ahead):
    healthy, left, right = taken((-50.0, -26.0, -26.0, -10.0 + ahead, -10.0))[:3]
    assert healthy == (3.0 if ahead > 0.0 else 4.0)
    assert (left, right) == (3.0, 4.0)


def test_a_lane_takes_over_another_suspect_where_its_own_pairs_are_impossible_too():
    assert taken((-50.0, -50.0, -9.0, -50.0, -10.0)) == (2.0, 2.0, KEEP, 2.0, KEEP)


def test_lanes_that_find_the_sample_possible_keep_their_states():
    assert taken((-10.0, -9.0, -9.0, -8.0, -8.0)) == (KEEP,) * 5


def test_all_go_on_from_the_one_that_is_declared():
    likelihoods = (-50.0, -26.0, -10.0, -26.0, -10.0)
    assert taken(likelihoods, changed=1.0) == (2.0, 2.0, KEEP, 2.0, 2.0)


def test_lanes_of_actuators_alone_go_on_by_themselves_until_something_is_declared():
    drives = ("drive_left", "drive_right")
    known = (*HYPOTHESES[:2], Hypothesis("both", (), drives), *(Hypothesis(name, (), (name,)) for name in drives))

    def taken_by(likelihoods, active=0.0, changed=0.0):
        source, far_off = selected_lane(known, likelihoods, active, IMPOSSIBLE)
        return adopted(known, source, best_pair_containing(known, likelihoods, IMPOSSIBLE), far_off, changed, active)

    left_explains = (-50.0, -10.0, -60.0, -50.0, -50.0)
    assert taken_by(left_explains) == (1.0, KEEP, KEEP, KEEP, KEEP)
    assert taken_by(left_explains, active=1.0) == (1.0, KEEP, 1.0, 1.0, 1.0)
    assert taken_by(left_explains, active=1.0, changed=1.0) == (1.0, KEEP, 1.0, 1.0, 1.0)
    assert taken_by((-50.0, -48.0, -5.0, -49.0, -50.0)) == (KEEP,) * 5, "nor does another go on from both"
    assert taken_by((-50.0, -48.0, -49.0, -5.0, -50.0)) == (KEEP,) * 5, "nor from one"
