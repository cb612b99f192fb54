"""Frequency response of a linear system."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.models.linear import LinearSystem
from tierod.models.modes import balance


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Complex gains from inputs to outputs.

    Args:
        frequency: [Hz], (frequencies,)
        gain: output over input, in their units, (frequencies, outputs, inputs)
        outputs, inputs: names
    """

    frequency: np.ndarray
    gain: np.ndarray
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]

    def of(self, output: str, input: str) -> np.ndarray:
        """The gain from one input to one output, (frequencies,).

        Raises:
            ParameterError: no such name
        """
        for name, names in ((output, self.outputs), (input, self.inputs)):
            if name not in names:
                raise ParameterError(f"there is no frequency response of '{name}'{nearest(name, names)}")
        return self.gain[:, self.outputs.index(output), self.inputs.index(input)]


def frequency_response(system: LinearSystem, frequency: Any, sample_time: float | None = None) -> FrequencyResponse:
    """C (j 2 pi f - A)^-1 B + D at every frequency, by one solution each, in balanced states.

    Args:
        system: continuous, or discrete where a sample_time is given
        frequency: [Hz]
        sample_time: of a discrete system [s]

    Raises:
        ParameterError: a frequency at which the gain is infinite, such as zero where an angle is free
    """
    frequency = np.atleast_1d(np.asarray(frequency, float))
    at = 2j * math.pi * frequency
    at = at if sample_time is None else np.exp(at * sample_time)
    n = len(system.A)
    scale = balance(system.A)
    A, B, C = system.A * scale / scale[:, None], system.B / scale[:, None], system.C * scale
    pencils = at[:, None, None] * np.eye(n) - A
    try:
        gain = C @ np.linalg.solve(pencils, np.broadcast_to(B.astype(complex), (len(at), *B.shape))) + system.D
    except np.linalg.LinAlgError:
        gain = np.full((1, 1, 1), np.inf)
    if not np.isfinite(gain).all():
        raise ParameterError(
            "the gain is infinite at one of the frequencies, an eigenvalue of the system; leave it out"
        )
    return FrequencyResponse(frequency, gain, system.outputs, system.inputs)


def decibels(gain: np.ndarray) -> np.ndarray:
    """20 log10 of the size [dB]."""
    return 20.0 * np.log10(np.abs(gain))


def phase(gain: np.ndarray) -> np.ndarray:
    """The phase without jumps, beginning between -180 and 180 degrees [deg]; NaN stays where it is."""
    known = np.isfinite(gain)
    turned = np.full(gain.shape, np.nan)
    turned[known] = np.degrees(np.unwrap(np.angle(gain[known])))
    return turned


def largest_difference(one: LinearSystem, other: LinearSystem, frequency: Any) -> float:
    """The largest gain of the difference of two systems with the same inputs and outputs, over the frequencies.

    The gain is the largest singular value, in the units of inputs and outputs as they are.
    """
    first, second = (frequency_response(system, frequency).gain for system in (one, other))
    return float(np.linalg.svd(first - second, compute_uv=False)[:, 0].max())
