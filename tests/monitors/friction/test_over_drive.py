"""What a report shows of friction over a drive."""

import numpy as np
import pytest

from tierod.monitors.friction.over_drive import EstimateOverDrive


def stretches(seconds, change=None):
    over = EstimateOverDrive(1.0)
    over.add(np.arange(seconds), np.full(seconds, 4.0), np.ones(seconds, bool))
    found = over.histograms(change)
    assert sum(counts.sum() for _, counts in found.values()) == seconds, "every estimate is in one stretch"
    return list(found)


@pytest.mark.parametrize(
    ("seconds", "titles"),
    [
        (61, ["0 to 15 s", "15 to 30 s", "30 to 45 s", "45 to 60 s"]),
        (781, ["0 to 3.2 min", "3.2 to 6.5 min", "6.5 to 9.8 min", "9.8 to 13 min"]),
        (3601, ["0 to 15 min", "15 to 30 min", "30 to 45 min", "45 to 60 min"]),
        (3, ["the whole drive"]),
        (1, ["the whole drive"]),
    ],
)
def test_stretches_have_titles_that_tell_them_apart(seconds, titles):
    assert stretches(seconds) == titles


@pytest.mark.parametrize("seconds", range(2, 1500, 7))
def test_no_length_of_a_drive_makes_two_titles_alike(seconds):
    assert len(stretches(seconds)) in (1, 4)


def test_a_change_parts_the_drive_in_two():
    assert stretches(600, change=300.0) == ["before the change", "after the change"]
