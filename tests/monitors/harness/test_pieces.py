import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.io.readers import SHARE_READ
from tierod.monitors.harness.pieces import LEAP, joined, pieces_of, refuse_leap, share_read
from tierod.vehicles import load


def piece(start, *names, **metadata):
    time = start + np.arange(5) * 0.1
    return Recording({name: Channel(name, time, 2.0 * time, "rad/s") for name in names}, metadata)


def test_the_end_of_the_piece_before_stands_in_front():
    whole = joined(piece(0.0, "yaw_rate", "speed"), piece(0.5, "yaw_rate", part=2))
    np.testing.assert_allclose(whole["yaw_rate"].time, np.arange(10) * 0.1)
    np.testing.assert_allclose(whole["yaw_rate"].values, np.arange(10) * 0.2)
    assert len(whole["speed"].time) == 5
    assert whole.metadata["part"] == 2


def test_the_first_piece_stands_alone():
    first = piece(0.0, "yaw_rate")
    assert joined(None, first) is first
    assert list(pieces_of(first, (), load("midsize-eps"), None, None)) == [first]


def test_a_night_is_borne_and_a_clock_that_leaps_is_not():
    refuse_leap(100.0, 100.0 + LEAP)
    with pytest.raises(InputError, match=r"jumps ahead from about 100 s by 1\.5 days; cut the recording there"):
        refuse_leap(100.0, 100.0 + 1.5 * LEAP)


def test_a_recording_in_memory_is_read_as_a_whole():
    assert share_read(piece(0.0, "yaw_rate")) == 1.0
    assert share_read(piece(0.0, "yaw_rate", **{SHARE_READ: 0.25})) == 0.25
