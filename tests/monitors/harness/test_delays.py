"""Delay and gain between two signals, with how sure they are."""

from __future__ import annotations

import numpy as np
import pytest

from tierod.monitors.harness.delays import BLOCK, LONGEST, RATE, LagOverDrive, _cross_correlation


def follower(delay: float, gain: float = 1.0, noise: float = 0.0, blocks: int = 10) -> LagOverDrive:
    """A sum of sines below 2 Hz, and a copy of it that is late."""
    chance = np.random.default_rng(5)
    frequency, phase = chance.uniform(0.05, 2.0, 20), chance.uniform(0.0, 6.0, 20)
    time = np.arange(blocks * BLOCK) / RATE

    def wave(at: np.ndarray) -> np.ndarray:
        return np.sin(2.0 * np.pi * np.outer(at, frequency) + phase).sum(axis=1)

    first = wave(time)
    second = gain * wave(time - delay) + noise * chance.normal(size=len(time))
    lag = LagOverDrive(0.1)
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
    assert LagOverDrive(0.1).found() is None


def test_the_cross_correlation_sums_products():
    first, second = np.random.default_rng(2).normal(size=(2, 200))
    for k, found in zip(range(-LONGEST, LONGEST + 1), _cross_correlation(first, second), strict=True):
        inside = [first[i] * second[i + k] for i in range(200) if 0 <= i + k < 200]
        assert found == pytest.approx(sum(inside), rel=1e-12, abs=1e-12)
