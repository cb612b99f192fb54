"""Signals from payload bytes: what a database describes need not be a number of a frame."""

import numpy as np
import pytest

from tierod.io.readers.bits import Payloads

FRAMES = np.arange(24, dtype=np.uint8).reshape(3, 8)


@pytest.mark.parametrize("big_endian", [False, True])
@pytest.mark.parametrize(
    ("start", "length", "real"),
    [(0, 0, False), (0, -1, False), (-1, 10, False), (33, 65, False), (33, 512, False), (0, 63, True), (0, 8, True)],
)
def test_no_number_of_a_frame_has_no_value(start, length, real, big_endian):
    values = Payloads(FRAMES).raw(start, length, big_endian, real=real)
    assert values.shape == (3,)
    assert np.isnan(values).all()


def test_a_signal_beyond_the_frame_is_zero_until_its_length_is_asked():
    assert not Payloads(FRAMES).raw(4096, 15, False).any()
