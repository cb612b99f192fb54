"""Noise of a column's sensors: of a bench, of production cars, or measured on the recording itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.residues import residue_of

FEWEST = 500
"""Samples from which on noise is measured."""
MARGIN = 1.25
"""What a filter expects over what was measured: motion hides some of the noise, and none of it is quite white."""
LONGEST_STEP = 0.01
"""For so long the same rounding error stays while a wheel turns, at most [s]; a wheel at rest shows none of it."""
SMALLER = 0.01
"""Share of a signal's changes that may be smaller than a step of its sensor: an export interpolates single values."""
SMOOTH = 1.4826 / math.sqrt(6.0)
"""Standard deviation of white noise over the median size of its second differences."""


@dataclass(frozen=True)
class SensorNoise:
    """Noise of both sensors, one standard deviation per sample, rounding included.

    The defaults are those of good transducers that are read every millisecond.

    Args:
        angle: of the steering wheel
        torque: of the torsion bar
    """

    angle: Annotated[float, "rad"] = math.radians(0.008)
    torque: Annotated[float, "N*m"] = 0.012


FINE = SensorNoise()
"""Sensors of a test bench."""

PRODUCTION = SensorNoise(angle=math.radians(0.04), torque=0.05)
"""Sensors of production cars, as their bus brings them."""

MOTOR_NOISE = math.radians(0.06)
"""Of the sensor of the motor's angle, rounding included: bench and production car read the same one [rad]."""


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
        max(_noise("steering_wheel_angle", angle, rate, usual.angle), 0.5 * FINE.angle),
        max(_noise("driver_torque", torque, rate, usual.torque), 0.5 * FINE.torque),
    )


def _noise(name: str, values: np.ndarray, rate: float, usual: float) -> float:
    second, first = np.diff(values, 2), np.diff(values)
    second, first = second[np.isfinite(second)], np.abs(first[np.isfinite(first)])
    changed = first[first > residue_of(name)]
    if len(second) < FEWEST or len(changed) < FEWEST // 10:
        return usual
    rounding = float(np.quantile(changed, SMALLER, method="lower")) / math.sqrt(12.0)
    lasting = min(len(first) / len(changed), max(LONGEST_STEP * rate, 1.0))
    return MARGIN * max(SMOOTH * float(np.median(np.abs(second))), rounding * math.sqrt(lasting))
