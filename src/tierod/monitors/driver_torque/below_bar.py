"""What turns below the torsion bar, as the torques of motor and bar and the motor's angle tell it."""

from __future__ import annotations

import numpy as np

SPAN = 0.02
"""Time over which rates are differences [s]: noise of the motor's angle makes 20 rad/s^2 of it, a sweep thousands."""

CLEAR = 10.0
"""The inertia counts from so many standard errors on: friction that follows the angle is no white noise."""

LEAST = 50.0
"""Standard deviation of the motor's acceleration below which nothing is said, twice that of its noise [rad/s^2]."""

SLIDING = 0.5
"""Speed of the motor over which dry friction changes its sign [rad/s]."""


class BelowBarOverDrive:
    """Least squares of motor torque + bar torque / ratio = inertia, damping, dry friction and a constant, piecewise.

    On a bench; in a car rack and road take part. Cuts between pieces lose a few samples.

    Args:
        ratio: turns of the motor per turn of the wheel
        rate: of the samples [Hz]
    """

    def __init__(self, ratio: float, rate: float) -> None:
        self._ratio, self._rate, self._step = ratio, rate, max(round(SPAN * rate), 1)
        self._products = np.zeros((5, 5))

    def add(self, motor_torque: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray) -> None:
        """The next piece: torques [N*m] and angle of the motor [rad], (n,) each; NaN where missing."""
        step, span = self._step, self._step / self._rate
        if len(motor_angle) <= 2 * step:
            return
        behind, now, ahead = motor_angle[: -2 * step], motor_angle[step:-step], motor_angle[2 * step :]
        speed = (ahead - behind) / (2.0 * span)
        bend = (ahead - 2.0 * now + behind) / span**2
        torque = (motor_torque + driver_torque / self._ratio)[step:-step]
        rows = np.column_stack([torque, bend, speed, np.tanh(speed / SLIDING), np.ones(len(now))])
        rows = rows[np.isfinite(rows).all(axis=1)]
        self._products += rows.T @ rows

    def inertia(self) -> float | None:
        """Of motor and gear at the motor's shaft [kg m^2]; None where the pieces do not say it clearly."""
        count = self._products[4, 4]
        normal, right = self._products[1:, 1:], self._products[1:, 0]
        size = np.sqrt(np.diag(normal))
        if not np.all(size > 0.0) or size[0] ** 2 < LEAST**2 * count:
            return None
        if np.linalg.cond(normal / np.outer(size, size)) > 1e8:
            return None
        share = np.linalg.solve(normal, right)
        spread = max(self._products[0, 0] - share @ right, 0.0) / count
        error = np.sqrt(spread * np.linalg.inv(normal)[0, 0])
        return float(share[0]) if share[0] > CLEAR * error else None
