"""What is taken does not depend on how the samples are cut into pieces."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.strides import Stride


@given(st.integers(1, 9), st.lists(st.integers(0, 25), max_size=12))
def test_pieces_give_what_the_whole_gives(step, lengths):
    stride, taken, begin = Stride(step), [], 0
    for length in lengths:
        taken += np.arange(begin, begin + length)[stride.over(length)].tolist()
        begin += length
    assert taken == list(range(0, begin, step))
