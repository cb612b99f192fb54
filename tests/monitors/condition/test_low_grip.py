"""Tyres that slide: when they are said to, on made-up likelihoods."""

import numpy as np
import pytest

from tierod.monitors.condition.low_grip import LowGrip

OTHERS = (0.0, -5.0, -8.0)


def steps(count, likelihood, lack, state=None):
    rule, found = LowGrip(), []
    state = rule.init() if state is None else state
    for _ in range(count):
        state, slides = rule.after(state, likelihood, OTHERS, lack, 0.01)
        found.append(bool(slides))
    return state, found


@pytest.mark.parametrize(("likelihood", "lack", "slides"), [(8.0, 0.4, True), (8.0, 0.05, False), (1.0, 0.4, False)])
def test_tyres_slide_where_forces_are_lacking_and_that_explains_most(likelihood, lack, slides):
    assert steps(30, likelihood, lack)[1][-1] is slides


def test_it_takes_the_mean_of_some_samples_and_stays_for_a_while():
    """The mean of a ratio of 8 is beyond 3 after log(8 / 5) of its time constant, which is 2.3 samples."""
    state, found = steps(10, 8.0, 0.4)
    assert found.index(True) == 2
    _, after = steps(100, -5.0, 0.0, state)
    assert sum(after) == pytest.approx(50, abs=5)
    assert not after[-1]


def test_a_sample_all_but_impossible_counts_no_more_than_its_limit():
    state, _ = steps(1, 1e6, 0.4)
    assert state.lead == pytest.approx(20.0 * (1.0 - np.exp(-0.2)))
