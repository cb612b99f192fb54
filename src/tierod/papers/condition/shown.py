"""When a fault can be told from noise at all, by likelihood ratio, whoever looks for it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

KNOWN = {
    "wheel_speed_rear_left": 0.015,
    "wheel_speed_rear_right": 0.015,
    "yaw_rate": 0.01,
    "steering_wheel_angle": 0.1,
    "steering_shaft_torque": 0.35,
    "tie_rod_force": 45.0,
    "steering_motor_1": 0.5,
    "steering_motor_2": 0.5,
    "drive_left": 10.0,
    "drive_right": 10.0,
}
"""How exactly everything else tells each element's true value: standard deviation [unit of the signal; N*m].

For sensors that is what is asked of a reconfigured value; for actuators it is assumed.
"""

ALIKE = 0.1
"""Over this time errors of the true value are alike, so that it counts once in a likelihood ratio [s]."""
ENOUGH = 4.5
"""Logarithm of the likelihood ratio that tells a fault: that of a deviation of three standard deviations."""


def where_shown(
    element: str, deviation: np.ndarray, faulty: np.ndarray, rate: float = 100.0, known: Mapping[str, float] = KNOWN
) -> np.ndarray:
    """Whether the fault of an element shows at each sample.

    The logarithm of the likelihood ratio between "faulty" and "healthy" over the last `ALIKE` seconds, for whoever
    knows what the reading should be with a standard deviation of `known`: mean squared deviation / (2 * known**2).

    Args:
        element: sensor or actuator
        deviation: of its reading, or its torque, from what it would be without fault
        faulty: whether the fault is there
        rate: samples per second [Hz]
        known: how exactly everything else tells each true value [unit of the signal; N*m]
    """
    count = max(round(ALIKE * rate), 1)
    largest = 1e3 * known[element]
    power = np.where(faulty, np.clip(np.asarray(deviation, float), -largest, largest), 0.0) ** 2
    total = np.concatenate([[0.0], np.cumsum(power)])
    past = np.minimum(np.arange(1, len(power) + 1), count)
    mean = (total[1:] - total[1 + np.arange(len(power)) - past]) / count
    return faulty & (mean / (2.0 * known[element] ** 2) >= ENOUGH)
