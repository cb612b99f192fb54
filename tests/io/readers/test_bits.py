"""Signals from payload bytes: what a database describes need not be a number of a frame."""

import numpy as np
import pytest
from cantools.database.can import Message, Signal
from cantools.database.conversion import BaseConversion

from tierod.io.readers.dbc import Payloads, span

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


@pytest.mark.parametrize("order", ["little_endian", "big_endian"])
@pytest.mark.parametrize("length", [12, 57, 60, 63, 64])
def test_signals_across_nine_bytes_are_what_cantools_decodes(order, length):
    random = np.random.default_rng(length)
    frames = random.integers(0, 256, (4, 16), dtype=np.uint8)
    big = order == "big_endian"
    for start in range(40):
        first, last = span(start, length, big)
        assert last - first == length
        for signed in (False, True):
            signal = Signal(
                "s", start, length, byte_order=order, conversion=BaseConversion.factory(1, 0), is_signed=signed
            )
            message = Message(1, "m", 16, [signal])
            found = Payloads(frames).raw(start, length, big, signed=signed)
            assert found.tolist() == [message.decode(row.tobytes())["s"] for row in frames], (start, signed)
