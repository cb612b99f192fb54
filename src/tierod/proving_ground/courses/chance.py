"""Smooth random curves: values drawn at uneven knots, joined without corners."""

from __future__ import annotations

import numpy as np

KNOTS = 4096
"""After so many knots a curve comes again: restlessness after three quarters of an hour, unevenness after 37 km."""


def smooth_noise(
    generator: np.random.Generator, shortest: float, longest: float, step: float, count: int = KNOTS
) -> np.ndarray:
    """A random curve of standard deviation one at its knots, on equal steps.

    Args:
        generator: source of chance
        shortest, longest: spacing of the knots, seconds or metres
        step: spacing of the result, in the same unit
        count: number of knots
    """
    knots = np.concatenate([[0.0], np.cumsum(generator.uniform(shortest, longest, count))])
    values = generator.standard_normal(count)
    place = np.arange(0.0, knots[-1], step)
    before = np.searchsorted(knots, place, side="right") - 1
    share = (place - knots[before]) / (knots[before + 1] - knots[before])
    share *= share * (3.0 - 2.0 * share)
    following = np.roll(values, -1)
    return values[before] + share * (following[before] - values[before])


class Repeated:
    """A curve on equal steps, read anywhere, beginning anew after its end."""

    def __init__(self, values: np.ndarray, step: float):
        self._values, self._rate = values, 1.0 / step

    def at(self, place: np.ndarray) -> np.ndarray:
        """The curve at some places, straight between its points."""
        position = place * self._rate
        before = np.floor(position).astype(np.intp)
        lower = self._values.take(before, mode="wrap")
        return lower + (position - before) * (self._values.take(before + 1, mode="wrap") - lower)


def band_limited(
    generator: np.random.Generator, lowest: float, highest: float, seconds: float, step: float
) -> np.ndarray:
    """A random curve of standard deviation one whose power is spread evenly over a band, on equal steps.

    Args:
        generator: source of chance
        lowest, highest: frequencies [Hz]
        seconds: length [s]
        step: spacing [s]
    """
    count = round(seconds / step) + 1
    frequency = np.fft.rfftfreq(count, step)
    inside = (frequency >= lowest) & (frequency <= highest)
    spectrum = inside * np.exp(2j * np.pi * generator.random(len(frequency)))
    curve = np.fft.irfft(spectrum, count)
    return curve / np.std(curve)
