"""Noise of a column's sensors: of a bench, of production cars, or measured on the recording itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.residues import residue_of

FEWEST = 500
"""Least number of samples for a measurement of the noise."""
MARGIN = 1.25
"""Noise assumed by a filter over the measured one; motion hides some of the noise, and none is quite white."""
LONGEST_STEP = 0.01
"""Longest time for which a rounding error stays the same while a wheel turns [s]; a wheel at rest shows none."""
SMALLER = 0.01
"""Share of a signal's changes that may be smaller than a step of its sensor; an export interpolates single values."""
SMOOTH = 1.4826 / math.sqrt(6.0)
"""Standard deviation of white noise over the median magnitude of its second differences."""


@dataclass(frozen=True)
class SensorNoise:
    """Noise of both sensors, one standard deviation per sample, rounding included.

    The defaults are those of good transducers read every millisecond.

    Args:
        angle: noise of the steering wheel angle
        torque: noise of the torque of the torsion bar
    """

    angle: Annotated[float, "rad"] = math.radians(0.008)
    torque: Annotated[float, "N*m"] = 0.012


FINE = SensorNoise()
"""Sensors of a test bench."""

PRODUCTION = SensorNoise(angle=math.radians(0.04), torque=0.05)
"""Sensors of production cars, as transmitted on their bus."""

MOTOR_NOISE = math.radians(0.06)
"""Noise of the motor's angle sensor, rounding included [rad]; bench and production car have the same one."""


def measured_noise(angle: np.ndarray, torque: np.ndarray, rate: float, usual: SensorNoise) -> SensorNoise:
    """Noise of both sensors per sample.

    Second differences contain the white noise, and hardly the motion of a wheel; steps of equal size reveal rounding,
    whose error lasts for several samples while the wheel turns slowly and then counts as correspondingly more noise.

    Args:
        angle: steering wheel angle [rad], (n,)
        torque: torque of the torsion bar [N*m], (n,)
        rate: sampling rate [Hz]
        usual: noise for a signal that is too short to measure
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
