"""Noise of the sensors of a column, measured on the recording itself."""

from __future__ import annotations

import math

import numpy as np

from tierod.monitors.driver_torque.hands_filters import FINE, SensorNoise

FEWEST = 500
"""Samples from which on noise is measured."""
MARGIN = 1.25
"""What a filter expects over what was measured: motion hides some of the noise, and none of it is quite white."""
LONGEST_STEP = 0.01
"""For so long the same rounding error stays while a wheel turns, at most [s]; a wheel at rest tells nothing of it."""
SMOOTH = 1.4826 / math.sqrt(6.0)
"""Standard deviation of white noise over the median size of its second differences."""


def measured_noise(angle: np.ndarray, torque: np.ndarray, rate: float, usual: SensorNoise) -> SensorNoise:
    """Noise of both sensors per sample.

    Second differences show white noise, and hardly the motion of a wheel; steps of one size show rounding, whose error
    stays for several samples while the wheel turns slowly and then weighs like that much more white noise.

    Args:
        angle: of the steering wheel [rad], (n,)
        torque: of the torsion bar [N*m], (n,)
        rate: of the samples [Hz]
        usual: for what is too short to be measured
    """
    return SensorNoise(
        max(_noise(angle, rate, usual.angle), 0.5 * FINE.angle),
        max(_noise(torque, rate, usual.torque), 0.5 * FINE.torque),
    )


def _noise(values: np.ndarray, rate: float, usual: float) -> float:
    second, first = np.diff(values, 2), np.diff(values)
    second, first = second[np.isfinite(second)], np.abs(first[np.isfinite(first)])
    changed = first[first > 0.0]
    if len(second) < FEWEST or len(changed) < FEWEST // 10:
        return usual
    rounding = float(np.min(changed)) / math.sqrt(12.0)
    lasting = min(len(first) / len(changed), max(LONGEST_STEP * rate, 1.0))
    return MARGIN * max(SMOOTH * float(np.median(np.abs(second))), rounding * math.sqrt(lasting))
