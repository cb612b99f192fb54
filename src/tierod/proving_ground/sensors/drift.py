"""Biases of sensors that wander."""

from __future__ import annotations

import math

import numpy as np


def gauss_markov(count: int, correlation: float, generator: np.random.Generator) -> np.ndarray:
    """A stationary first-order Gauss-Markov series of standard deviation one, shape (count,).

    Args:
        count: how many samples
        correlation: after how many samples the autocorrelation has fallen to 1/e
        generator: source of chance

    Source: A. Gelb (ed.), Applied Optimal Estimation, MIT Press (1974), section 3.8.
    """
    from scipy.signal import lfilter

    kept = math.exp(-1.0 / correlation)
    driving = generator.standard_normal(count)
    driving[1:] *= math.sqrt(1.0 - kept * kept)
    return lfilter([1.0], [1.0, -kept], driving)


def random_walk(count: int, step_time: float, generator: np.random.Generator) -> np.ndarray:
    """A random walk that begins at zero, of standard deviation sqrt(time), shape (count,).

    Args:
        count: how many samples
        step_time: between two samples [s]
        generator: source of chance
    """
    steps = math.sqrt(step_time) * generator.standard_normal(count)
    steps[:1] = 0.0
    return np.cumsum(steps)
