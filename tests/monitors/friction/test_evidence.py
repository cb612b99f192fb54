"""What a report shows of friction over a drive."""

import numpy as np
import pytest

from tierod.monitors.friction.evidence import STROKES, EstimateOverDrive, HysteresisOverDrive


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
def test_stretches_have_titles_that_distinguish_them(seconds, titles):
    assert stretches(seconds) == titles


def test_a_change_parts_the_drive_in_two():
    assert stretches(600, change=300.0) == ["before the change", "after the change"]


def views_of(seconds, pieces):
    """Views of a drive at 100 Hz whose friction counts its samples, with more samples used later, cut in pieces."""
    rate, over = 100, HysteresisOverDrive(100.0)
    time = np.arange(seconds * rate) / rate
    used = np.sin(0.1 * time) < -0.9 + time / seconds
    for each in np.array_split(np.arange(len(time)), pieces):
        over.add(time[each], time[each], time[each] * 2.0, used[each])
    return over.views(None)


def test_strokes_are_the_same_however_the_drive_is_cut():
    whole, cut = views_of(1500, 1), views_of(1500, 1499)
    assert list(whole) == list(cut) == ["2 to 13 min", "13 to 25 min"]
    for name in whole:
        np.testing.assert_array_equal(whole[name], cut[name])


def test_the_busiest_strokes_of_ten_minutes_are_shown():
    angle, friction = views_of(600, 60)["6.5 to 9.2 min"]
    known = np.isfinite(friction)
    np.testing.assert_allclose(friction[known], 2.0 * angle[known])
    assert np.isnan(angle).sum() <= STROKES, "a gap after each stroke"
    assert known.mean() > 0.85, "the estimator used most samples of the busiest strokes"
