"""Running statistics, fed in pieces, and their consistency."""

from __future__ import annotations

import numpy as np
import pytest

from example_models import Cart, CartParameters, Two
from tierod.core.graph import scan
from tierod.methods.analysis.consistency import ConsistencyAccumulator
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.running import BLOCK, RATE, LaggedCorrelation, Moments


def follower(delay: float, gain: float = 1.0, noise: float = 0.0, blocks: int = 10) -> LaggedCorrelation:
    """A sum of sines below 2 Hz, and a copy of it that is late."""
    chance = np.random.default_rng(5)
    frequency, phase = chance.uniform(0.05, 2.0, 20), chance.uniform(0.0, 6.0, 20)
    time = np.arange(blocks * BLOCK) / RATE

    def wave(at: np.ndarray) -> np.ndarray:
        return np.sin(2.0 * np.pi * np.outer(at, frequency) + phase).sum(axis=1)

    first = wave(time)
    second = gain * wave(time - delay) + noise * chance.normal(size=len(time))
    lag = LaggedCorrelation(0.1)
    for block in range(blocks):
        part = slice(block * BLOCK, (block + 1) * BLOCK)
        lag.add(first[part], second[part])
    return lag


@pytest.mark.parametrize("delay", [0.0, 0.013, -0.013, 0.1, -0.5, 0.87])
def test_a_delay_is_found_between_the_samples(delay):
    found = follower(delay).found()
    assert found.delay == pytest.approx(delay, abs=0.003)
    assert abs(found.correlation) > 0.97
    assert found.deviation < 0.005


def pieces(values):
    return np.split(values, [1, 17, 17, 400])


def test_moments_are_those_of_all_samples_together():
    rows = np.random.default_rng(3).normal([1e6, -3.0], [0.1, 2.0], (900, 2)) @ np.array([[1.0, 0.4], [0.0, 1.0]])
    rows[5, 0] = np.nan
    found = Moments()
    for part in pieces(rows):
        found.add(*part.T)
    whole = np.delete(rows, 5, axis=0)
    assert found.count == 899
    assert found.correlation() == pytest.approx(np.corrcoef(whole.T)[0, 1], rel=1e-6)
    assert found.ratio() == pytest.approx(np.std(whole[:, 1]) / np.std(whole[:, 0]), rel=1e-6)
    assert found.means == pytest.approx(whole.mean(axis=0), rel=1e-12)


CART_FILTER = KalmanFilter(
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


def test_a_right_model_is_consistent_and_honest():
    samples, truth = run()
    result = scan(CART_FILTER, samples)
    first, both, second = result.values[:, [k for k, name in enumerate(result.names) if "covariance" in name]].T
    error = result.values[:, :2] - truth
    weights = np.linalg.inv(np.moveaxis([[first, both], [both, second]], 2, 0))
    accumulator = ConsistencyAccumulator()
    for part in np.array_split(np.arange(len(samples)), 7):
        accumulator.add(result["nis"][part], result["present"][part])
    found = accumulator.result()
    assert found.measurements == np.isfinite(samples[:, 1:]).sum()
    assert found.samples == np.isfinite(samples[:, 1:]).any(axis=1).sum()
    assert found.nis_band[0] < found.nis < found.nis_band[1]
    assert found.outside == pytest.approx(0.05, abs=0.01)
    assert np.einsum("ni,nij,nj->n", error, weights, error).mean() / 2.0 == pytest.approx(1.0, abs=0.05)
