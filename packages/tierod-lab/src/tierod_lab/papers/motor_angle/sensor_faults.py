"""Faults of a motor angle sensor and of a current sensor: kinds and magnitudes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

DEGREE = math.radians(1.0) / 4.0  # One degree of the electrical angle of four pole pairs, as angle of the shaft [rad]
FIVE_DEGREES = 5.0 * DEGREE
"""Five degrees electrical, the smallest offset that deserves an alarm, as angle of the shaft [rad]."""


@dataclass(frozen=True)
class Fault:
    """Effect of a fault on a signal, over the time since its start."""

    name: str  # name in words
    # gain, offset: gain and offset of the signal, as functions of the time [s]
    gain: Callable[[np.ndarray], np.ndarray] = np.ones_like
    offset: Callable[[np.ndarray], np.ndarray] = np.zeros_like
    # whether the gain acts about the angle at the start of the fault, so that the signal does not jump
    from_here: bool = False
    held: bool = False  # whether the signal is stuck
    quantum: float = 0.0  # resolution of the recorded signal; the control still reads the fine one [rad]
    signal: str = "motor_angle_mechanical"  # name of the faulty signal
    size: float = 0.0  # time until the fault is as large as an offset of five degrees electrical [s]


def _constant(value: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda time: np.full_like(time, value)


def offset(degrees: float) -> Fault:
    """Constant electrical offset [deg], as of a magnet that has slipped."""
    return Fault(f"offset of {degrees:g}° electrical", offset=_constant(degrees * DEGREE))


def drift(degrees: float) -> Fault:
    """Electrical offset that grows at a rate [deg/s]."""
    name = f"drift of {degrees:g}°/s electrical"
    return Fault(name, offset=lambda time: degrees * DEGREE * time, size=5.0 / degrees)


def gain(percent: float) -> Fault:
    """Gain that is too large [%], about the angle at the start of the fault."""
    return Fault(f"gain {percent:g} % too large", gain=_constant(1.0 + 0.01 * percent), from_here=True)


def noise(degrees: float) -> Fault:
    """Additional white noise of an electrical standard deviation [deg]."""
    return Fault(
        f"noise of {degrees:g}° electrical",
        offset=lambda time: degrees * DEGREE * np.random.default_rng(5).normal(size=len(time)),
    )


def coarse(degrees: float) -> Fault:
    """Coarse electrical resolution [deg], as of lost bits."""
    return Fault(f"steps of {degrees:g}° electrical", quantum=degrees * DEGREE)


def intermittent(degrees: float) -> Fault:
    """Electrical offset [deg] that lasts 5 ms, ten times a second."""
    return Fault(
        f"{degrees:g}° electrical for 5 ms, ten times a second",
        offset=lambda time: degrees * DEGREE * ((time + 1e-9) % 0.1 < 5e-3),
    )


STUCK = Fault("stuck", held=True)
SWAPPED_SINE = Fault("sine and cosine swapped", gain=_constant(-1.0), offset=_constant(90.0 * DEGREE))
SWAPPED_PHASES = Fault("current phases b and c swapped", gain=_constant(-1.0), signal="motor_current_beta")

FAULTS = (
    *map(offset, (2.0, 5.0, 10.0, 60.0)),
    *map(drift, (5.0, 20.0, 100.0)),
    *map(gain, (2.0, 10.0)),
    *map(noise, (10.0, 30.0)),
    *map(coarse, (20.0, 60.0)),
    *map(intermittent, (20.0, 60.0)),
    STUCK,
    SWAPPED_SINE,
    SWAPPED_PHASES,
)
"""All faults, by kind and from small to large."""
