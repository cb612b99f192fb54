"""Running statistics: delay and gain between two signals, moments, sizes, outermost levels, fed in pieces."""

from __future__ import annotations

import numpy as np
import pytest

from tierod.methods.running import (
    BLOCK,
    LONGEST,
    RATE,
    LaggedCorrelation,
    Moments,
    OuterLevels,
    Sizes,
    cross_correlation,
)


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


@pytest.mark.parametrize("gain", [0.5, 2.0, -1.0])
def test_the_gain_is_that_of_the_second_over_the_first(gain):
    found = follower(0.01, gain).found()
    assert found.gain == pytest.approx(gain, rel=0.06)
    assert found.delay == pytest.approx(0.01, abs=0.003)


def test_the_deviation_holds_what_noise_does():
    errors = [follower(0.1, noise=6.0).found()]
    assert abs(errors[0].delay - 0.1) < 4.0 * errors[0].deviation
    assert errors[0].deviation > follower(0.1).found().deviation
    assert errors[0].correlation < 0.6


def test_blocks_that_say_nothing_are_left_out():
    lag = follower(0.1)
    before = lag.found()
    lag.add(np.full(BLOCK, np.nan), np.ones(BLOCK))
    lag.add(np.full(BLOCK, 3.0), np.ones(BLOCK))
    assert lag.found() == before
    assert LaggedCorrelation(0.1).found() is None


def test_the_cross_correlation_sums_products():
    first, second = np.random.default_rng(2).normal(size=(2, 200))
    for k, found in zip(range(-LONGEST, LONGEST + 1), cross_correlation(first, second, LONGEST), strict=True):
        inside = [first[i] * second[i + k] for i in range(200) if 0 <= i + k < 200]
        assert found == pytest.approx(sum(inside), rel=1e-12, abs=1e-12)


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


def test_the_outermost_levels_are_those_of_all_samples_together():
    values = np.round(np.random.default_rng(8).normal(size=2000), 1)
    found = OuterLevels()
    for part in pieces(values):
        found.add(part)
    levels, counts = np.unique(values, return_counts=True)
    (low, least, few, near), (high, most, many, beside) = found.ends()
    assert (low, least, [few, *near]) == ("lower", levels[0], counts[:4].tolist())
    assert (high, most, [many, *beside]) == ("upper", levels[-1], counts[:-5:-1].tolist())


def test_quantiles_of_sizes_are_right_to_a_bin():
    values = np.random.default_rng(9).normal(size=5000)
    found = Sizes()
    for part in pieces(values):
        found.add(part)
    assert found.quantile(0.5) == pytest.approx(np.quantile(np.abs(values), 0.5), rel=0.06)
