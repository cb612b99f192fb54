"""Consistency against slow oracles."""

import dataclasses
import math

import numpy as np
import pytest
from scipy import stats

from example_models import Cart, CartParameters, Two
from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.methods.analysis.consistency import (
    ConsistencyAccumulator,
    chi_square_quantile,
    consistency,
    mean_band,
)
from tierod.methods.estimators import KalmanFilter


def test_chi_square_is_that_of_scipy_stats():
    for degrees in (1, 2, 50, 3_000_000):
        assert chi_square_quantile(0.975, degrees) == pytest.approx(stats.chi2.ppf(0.975, degrees), rel=1e-9)
    assert mean_band(100) == pytest.approx(np.array(stats.chi2.interval(0.95, 100)) / 100)


def test_nothing_has_no_band():
    assert all(map(math.isnan, mean_band(0)))


BLOCK = KalmanFilter(
    Cart,
    CartParameters(),
    initial_mean=(0.0, 0.0),
    initial_variance=(1.0, 1.0),
    process_noise=(0.02, 0.01),
    measurement_noise=(0.1, 0.2),
    full_covariance=True,
)


def run(count=20_000, seed=0, missing=0.2):
    rng = np.random.default_rng(seed)
    state = Two(*rng.normal(size=2).tolist())
    rows, truth = [], []
    force = rng.normal(size=count)
    for k in range(count):
        state = Cart.transition(state, Cart.Input(float(force[k])), CartParameters())
        state = Two(*(np.array(state) + rng.normal(size=2) * np.sqrt([0.02, 0.01])).tolist())
        rows.append([force[k], *(np.array(state) + rng.normal(size=2) * np.sqrt([0.1, 0.2]))])
        truth.append(state)
    samples = np.array(rows)
    samples[:, 1:][rng.random((count, 2)) < missing] = np.nan
    return samples, np.array(truth)


@pytest.fixture(scope="module")
def cart():
    samples, truth = run()
    return samples, truth, scan(BLOCK, samples)


def test_a_right_model_is_consistent_white_and_honest(cart):
    samples, truth, result = cart
    first, both, second = result.values[:, [k for k, name in enumerate(result.names) if "covariance" in name]].T
    error = result.values[:, :2] - truth
    weights = np.linalg.inv(np.moveaxis([[first, both], [both, second]], 2, 0))
    found = consistency(result)
    assert found.measurements == np.isfinite(samples[:, 1:]).sum()
    assert found.samples == np.isfinite(samples[:, 1:]).any(axis=1).sum()
    assert found.consistent
    assert found.white
    assert found.outside == pytest.approx(0.05, abs=0.01)
    assert np.einsum("ni,nij,nj->n", error, weights, error).mean() / 2.0 == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(
    ("changes", "above"),
    [({"measurement_noise": (0.05, 0.1)}, True), ({"measurement_noise": (0.2, 0.4)}, False)],
)
def test_wrong_noise_is_seen(cart, changes, above):
    found = consistency(scan(dataclasses.replace(BLOCK, **changes), cart[0]))
    assert found.consistent is False
    assert (found.nis > found.nis_band[1]) == above


def test_a_wrong_model_is_not_white(cart):
    wrong = dataclasses.replace(BLOCK, parameters=CartParameters(mass=0.4, damping=0.1), process_noise=(0.001, 0.001))
    assert consistency(scan(wrong, cart[0])).white is False


def test_chunks_give_the_same_as_the_whole(cart):
    *_, result = cart
    names = [[f"{what}.{name}" for name in ("position", "speed")] for what in ("innovation", "innovation_variance")]
    columns = [np.column_stack([result[name] for name in group]) for group in names]
    accumulator = ConsistencyAccumulator()
    for part in np.array_split(np.arange(len(result)), 37):
        accumulator.add(result["nis"][part], result["present"][part], columns[0][part], columns[1][part])
    whole, chunked = consistency(result), accumulator.result()
    np.testing.assert_allclose(chunked.lags, whole.lags, rtol=1e-9)
    for field in ("samples", "measurements", "nis", "nis_band", "outside", "whiteness", "whiteness_band"):
        assert getattr(chunked, field) == pytest.approx(getattr(whole, field), rel=1e-9)


def test_chunks_shorter_than_the_lags():
    rng = np.random.default_rng(0)
    innovation = rng.normal(size=(100, 1))
    whole, small = ConsistencyAccumulator(8), ConsistencyAccumulator(8)
    one = np.ones(100)
    whole.add(one, one, innovation, np.ones((100, 1)))
    for k in range(0, 100, 3):
        part = slice(k, k + 3)
        small.add(one[part], one[part], innovation[part], np.ones((100, 1))[part])
    np.testing.assert_allclose(small.result().lags, whole.result().lags)


def test_autocorrelation_is_the_textbook_one():
    rng = np.random.default_rng(1)
    white = rng.normal(size=3000)
    coloured = white[1:] + 0.8 * white[:-1]
    accumulator = ConsistencyAccumulator(5)
    ones = np.ones(len(coloured))
    accumulator.add(ones, ones, coloured[:, None] * 3.0, np.full((len(coloured), 1), 9.0))
    found = accumulator.result()
    expected = [np.mean(coloured[k:] * coloured[: len(coloured) - k]) / np.mean(coloured**2) for k in range(1, 6)]
    np.testing.assert_allclose(found.lags[0], expected, rtol=1e-9)
    assert found.whiteness == pytest.approx(0.8 / 1.64, abs=0.05)
    assert found.white is False


def test_white_innovations_are_called_white_as_often_as_stated():
    white = 0
    for seed in range(200):
        accumulator = ConsistencyAccumulator(10)
        innovation = np.random.default_rng(seed).normal(size=(400, 2))
        accumulator.add(np.ones(400), np.ones(400), innovation, np.ones((400, 2)))
        white += accumulator.result().white
    assert 180 <= white <= 200


def test_a_run_without_measurements_gives_no_figure():
    empty = scan(BLOCK, np.full((30, 3), np.nan))
    found = consistency(empty)
    assert (found.samples, found.measurements) == (0, 0)
    assert math.isnan(found.nis)
    assert found.consistent is None
    assert found.white is None
    assert ConsistencyAccumulator().result().white is None


@pytest.mark.parametrize(
    "call",
    [
        lambda a: a.add(np.ones(3), np.ones(4)),
        lambda a: a.add(np.ones(3), np.ones(3), np.ones((2, 1)), np.ones((2, 1))),
    ],
)
def test_arrays_that_do_not_fit_are_refused(call):
    with pytest.raises(InputError):
        call(ConsistencyAccumulator())
