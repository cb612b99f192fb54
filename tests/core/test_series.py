"""Parts of a series of samples: runs of true values, and every k-th sample wherever its pieces are cut."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.series import Stride, last_true, longest_run, runs


@pytest.mark.parametrize(
    ("flags", "expected"),
    [
        ([], []),
        ([0, 0], []),
        ([1], [(0, 1)]),
        ([1, 1, 0, 1], [(0, 2), (3, 4)]),
        ([0, 1, 0, 0, 1, 1], [(1, 2), (4, 6)]),
    ],
)
def test_first_and_past_the_last_index_of_every_run(flags, expected):
    begins, ends = runs(np.array(flags, dtype=bool))
    assert list(zip(begins.tolist(), ends.tolist(), strict=True)) == expected


def test_the_longest_run():
    assert longest_run(np.array([0, 1, 1, 0, 1, 1, 1, 0], dtype=bool)) == 3
    assert longest_run(np.zeros(3, dtype=bool)) == 0


@given(st.integers(1, 9), st.lists(st.integers(0, 25), max_size=12))
def test_pieces_give_what_the_whole_gives(step, lengths):
    stride, taken, begin = Stride(step), [], 0
    for length in lengths:
        taken += np.arange(begin, begin + length)[stride.over(length)].tolist()
        begin += length
    assert taken == list(range(0, begin, step))


@given(st.lists(st.booleans(), max_size=30))
def test_the_last_true_value(flags):
    places = [at for at, flag in enumerate(flags) if flag]
    assert last_true(np.array(flags, bool)) == (places[-1] if places else None)
