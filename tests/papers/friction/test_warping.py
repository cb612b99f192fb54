"""Against the textbook's recursion, path by path, and against known stretches."""

import itertools

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.papers.friction.warping import _path, _totals, warped


def every_path(samples, band):
    def onward(path):
        i, j = path[-1]
        if (i, j) == (samples - 1, samples - 1):
            yield path
        for di, dj in ((1, 1), (1, 0), (0, 1)):
            if i + di < samples and j + dj < samples and abs(i + di - j - dj) <= band:
                yield from onward([*path, (i + di, j + dj)])

    return list(onward([(0, 0)]))


@pytest.mark.parametrize("band", [0, 1, 2, 4])
def test_the_sum_is_that_of_the_best_of_all_paths(band):
    random = np.random.default_rng(band)
    moved, fixed = random.normal(size=(2, 7, 5))
    paths = every_path(5, band)
    totals = _totals(moved, fixed, band)
    first, last = _path(totals, band)
    for row in range(7):
        least = min(sum(abs(fixed[row, i] - moved[row, j]) for i, j in path) for path in paths)
        assert totals[4, row, band + 1] == pytest.approx(least)
        runs = [range(first[row, i], last[row, i] + 1) for i in range(5)]
        assert runs[0][0] == 0
        assert runs[4][-1] == 4
        assert all(later[0] - before[-1] in (0, 1) for before, later in itertools.pairwise(runs))
        found = sum(abs(fixed[row, i] - moved[row, j]) for i, run in enumerate(runs) for j in run)
        assert found == pytest.approx(least)
        means = [moved[row, list(run)].mean() for run in runs]
        assert warped(moved, fixed, band)[row] == pytest.approx(means)


def test_a_stretched_course_comes_back():
    time = np.linspace(0.0, 6.0, 300)
    fixed = np.sin(2.0 * time)[None]
    moved = np.sin(2.0 * (time + 0.2 * np.sin(time)))[None]
    aligned = warped(moved, fixed, 20)
    assert np.abs(moved - fixed).max() > 0.2
    away = np.abs(aligned - fixed)[0]
    assert away[:-10].max() < 0.05  # common ends, so the last samples cannot be moved
    assert np.sqrt(np.mean(away**2)) < 0.02


def test_a_band_of_none_leaves_all_as_it_is_and_wrong_shapes_are_refused():
    moved = np.arange(12.0).reshape(2, 6)
    assert np.array_equal(warped(moved, moved[::-1], 0), moved)
    with pytest.raises(ParameterError, match="do not match"):
        warped(moved, moved[:, :5], 1)
    with pytest.raises(ParameterError, match="zero or more"):
        warped(moved, moved, -1)
