"""Modulating functions: weighted means of derivatives of noisy signals without numerical differentiation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Modulation:
    """Weighted means over a sliding window; by partial integration, derivatives act on the weight, which is known.

    The weight is sin^4: it and its first three derivatives are zero at the ends, so that no boundary terms remain. Rows
    whose window contains a missing sample are NaN.

    Args:
        step: sampling interval [s]

    Source: M. Shinbrot, Trans. ASME 79 (1957) 547.
    """

    length: int
    stride: int
    step: float

    def growth(self, values: np.ndarray) -> np.ndarray:
        """Mean rate of a signal from its increments; exact for a rate that is constant over a step."""
        return self.between(np.diff(values) / self.step)

    def between(self, values: np.ndarray) -> np.ndarray:
        """Mean of values that belong to the steps between samples, (n - 1,) for a signal of n samples."""
        return self._rows(values, self._steps)

    @property
    def gain(self) -> tuple[float, float]:
        """Standard deviations of `between` [-] and `growth` [1/s] for white noise of standard deviation one."""
        edges = np.diff(np.concatenate([[0.0], self._steps, [0.0]]))
        return float(np.sqrt(np.sum(self._steps**2))), float(np.sqrt(np.sum(edges**2))) / self.step

    def mean(self, values: np.ndarray) -> np.ndarray:
        return self._rows(values, np.sin(self._places) ** 4 * self._scale)

    def rate(self, values: np.ndarray) -> np.ndarray:
        """Mean rate of a signal that is smooth over a window."""
        slope = 4.0 * np.sin(self._places) ** 3 * np.cos(self._places)
        return self._rows(values, -slope * self._scale * self._turn)

    def acceleration(self, values: np.ndarray) -> np.ndarray:
        """Mean second derivative of a signal that is smooth over a window."""
        sine, cosine = np.sin(self._places), np.cos(self._places)
        bend = 12.0 * sine**2 * cosine**2 - 4.0 * sine**4
        return self._rows(values, bend * self._scale * self._turn**2)

    @property
    def _steps(self) -> np.ndarray:
        weight = np.sin(np.pi * (np.arange(self.length) + 0.5) / self.length) ** 4
        return np.asarray(weight / weight.sum())

    @property
    def _places(self) -> np.ndarray:
        return np.pi * np.arange(self.length + 1) / self.length

    @property
    def _scale(self) -> float:
        return 8.0 / (3.0 * self.length)

    @property
    def _turn(self) -> float:
        return float(np.pi / (self.length * self.step))

    def _rows(self, values: np.ndarray, weight: np.ndarray) -> np.ndarray:
        return np.convolve(values, weight[::-1], "valid")[:: self.stride]
