import numpy as np
import pytest

from tierod.monitors.driver_torque.evidence import Stretch, Stretches

STEP = 0.1


def found(hands, *cuts):
    """Stretches of states given at 10 Hz, taken in in pieces cut at some samples."""
    stretches, time = Stretches(STEP), np.arange(len(hands)) * STEP
    for part in np.split(np.arange(len(hands)), cuts):
        stretches.add(time[part], np.asarray(hands, float)[part])
    return stretches.found()


def test_stretches_begin_and_end_where_the_state_changes():
    assert found([1, 0, 0, 0, 1, 0.5, 0, 1]) == [
        pytest.approx(Stretch(0.1, 0.3)),
        pytest.approx(Stretch(0.6, 0.1)),
    ]


def test_one_that_lasts_until_the_end_counts_with_its_last_sample():
    assert found([1, 1, 0, 0]) == [pytest.approx(Stretch(0.2, 0.2))]


def test_pieces_make_no_difference():
    hands = [0, 0, 1, 0, 0, 0, 1, 1, 0]
    assert found(hands, 1, 4, 5, 8) == [pytest.approx(each) for each in found(hands)]


def test_no_stretch_without_off():
    assert found([1, 0.5, 1]) == []
