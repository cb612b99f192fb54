import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from example_models import with_gaps
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors import MovingMoments


def window_moments(values, size):
    rows = []
    for k in range(len(values)):
        window = values[max(0, k - size + 1) : k + 1]
        window = window[np.isfinite(window)]
        mean = window.mean() if len(window) else np.nan
        rows.append([mean, window.var(ddof=1) if len(window) > 1 else 0.0, len(window)])
    return np.array(rows)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000), st.sampled_from([2, 3, 17]), st.sampled_from([0.0, 0.4, 0.95]))
def test_moving_moments_agree_with_the_window(seed, size, gaps):
    rng = np.random.default_rng(seed)
    values = with_gaps(rng, rng.normal(size=120) + 50.0, gaps)
    expected, found = window_moments(values, size), scan(MovingMoments(size), values)
    some = expected[:, 2] > 0
    np.testing.assert_array_equal(found["number"], expected[:, 2])
    np.testing.assert_allclose(found["mean"][some], expected[some, 0], rtol=1e-10)
    np.testing.assert_allclose(found["variance"], expected[:, 1], rtol=1e-7, atol=1e-10)


def test_moving_moments_do_not_drift_and_a_large_mean_does_no_harm():
    rng = np.random.default_rng(0)
    values = 1e6 + 1e5 * np.sin(np.arange(300_000) * 1e-4) + rng.normal(size=300_000)
    found = scan(MovingMoments(100), values)
    last = values[-100:]
    assert found["variance"][-1] == pytest.approx(last.var(ddof=1), rel=1e-6)
    assert found["mean"][-1] == pytest.approx(last.mean(), rel=1e-12)


def test_a_spike_is_forgotten_within_three_windows_and_at_once_after_a_gap():
    values = np.random.default_rng(4).normal(size=1000)
    values[500] = 1e9
    found = scan(MovingMoments(50), values)["variance"]
    np.testing.assert_allclose(found[650:], window_moments(values, 50)[650:, 1], rtol=1e-6)
    assert found[530] > 1e15
    values[500], values[525], values[530:590] = 0.0, 1e9, np.nan
    found = scan(MovingMoments(50), values)["variance"]
    np.testing.assert_allclose(found[590:], window_moments(values, 50)[590:, 1], rtol=1e-6)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: MovingMoments(1), "at least 2 samples"),
    ],
)
def test_wrong_tuning_is_refused(make, words):
    with pytest.raises(ParameterError, match=words):
        make()
