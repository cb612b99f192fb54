"""Runs of true values."""

import numpy as np
import pytest

from tierod.core.runs import longest_run, runs


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
